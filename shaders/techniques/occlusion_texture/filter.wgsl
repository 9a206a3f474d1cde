// One step of a filter of the slices' pictures, for up to four targets of four slices each.
// Host    src/techniques/occlusion_texture/gpu/passes.rs
// Groups  0 the level below
// Twin    techniques::occlusion_texture::filter
// Sources: Décoret 2005, "N-Buffers for efficient depth map query"; Williams 1983, "Pyramidal parametrics"; Hensley et al.
//         2005, "Fast summed-area table generation and its applications", for sums by few passes with several loads.
//
// These are draws, because Mesa's software driver takes three times as long to store a texel from a compute shader as to
// draw it: compute shaders that share loads between the texels of two or three levels are slower there.

@group(0) @binding(0) var below: texture_2d_array<f32>;
// Takes single texels; for `adjacent_level`, blends the four around a place.
@group(0) @binding(1) var texels: sampler;

override GROUPS: u32 = 1u;
// Texels of the level below for each texel along a side: 2 for `adjacent_level` where levels get smaller.
override STRIDE: u32 = 1u;

// Texels that one pass of a sum adds up.
const RADIX: i32 = 8;               // mirror: techniques::occlusion_texture::gpu::textures::RADIX

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) instance: u32,
}

struct Targets {
    @location(0) a: vec4f,
    @location(1) b: vec4f,
    @location(2) c: vec4f,
    @location(3) d: vec4f,
}

// A texel, from its middle. It is sampled, since Mesa's software driver takes 1.2 to 1.7 times as long to load texels.
fn sampled(middle: vec2f, group: i32) -> vec4f {
    return textureSampleLevel(below, texels, middle, group, 0.0);
}

// A texel; 0 outside.
fn load(texel: vec2i, group: i32) -> vec4f {
    let size = vec2i(textureDimensions(below));
    let inside = all(texel >= vec2i(0)) && all(texel < size);
    return select(vec4f(0.0), sampled((vec2f(texel) + 0.5) / vec2f(size), group), inside);
}

// Means of four texels that are `step` apart. The first is inside, and what is outside counts as 0.
fn means(texel: vec2i, step: i32) -> Targets {
    // Sides are powers of two, so these are the middles of texels exactly.
    let size = vec2f(textureDimensions(below));
    let near = (vec2f(texel) + 0.5) / size;
    let far = near + f32(step) / size;
    let inside = select(vec2f(0.0), vec2f(1.0), far < vec2f(1.0));
    var out: array<vec4f, 4>;
    for (var group = 0; group < i32(GROUPS); group++) {
        let top = sampled(near, group) + inside.x * sampled(vec2f(far.x, near.y), group);
        let bottom = sampled(vec2f(near.x, far.y), group) + inside.x * sampled(far, group);
        out[group] = 0.25 * (top + inside.y * bottom);
    }
    return Targets(out[0], out[1], out[2], out[3]);
}

// The next level from means of four adjacent texels: the first of an N-buffer, or any of mipmaps. The sample between the texels
// is their mean. It repeats texels at the border, where half of them is what the others lack.
@fragment
fn adjacent_level(in: Corner) -> Targets {
    let between = (f32(STRIDE) * floor(in.position.xy) + 1.0) / vec2f(textureDimensions(below));
    let inside = select(vec2f(0.5), vec2f(1.0), between < vec2f(1.0));
    var out: array<vec4f, 4>;
    for (var group = 0; group < i32(GROUPS); group++) {
        out[group] = inside.x * inside.y * sampled(between, group);
    }
    return Targets(out[0], out[1], out[2], out[3]);
}

// The next level of an N-buffer, with as many texels. The instance is the side of the squares of the level below, texels.
@fragment
fn level(in: Corner) -> Targets {
    return means(vec2i(in.position.xy), i32(in.instance));
}

// The next level of an N-buffer, with half as many texels along a side. The instance is the side of the squares of
// the level below, in texels of that level.
@fragment
fn halved_level(in: Corner) -> Targets {
    return means(2 * vec2i(in.position.xy), i32(in.instance));
}

// The depth of a slice's top where it lies inside of closed casters, from what their surfaces add; 0 elsewhere.
@fragment
fn fill(in: Corner) -> Targets {
    var out: array<vec4f, 4>;
    for (var group = 0; group < i32(GROUPS); group++) {
        let crossings = load(vec2i(in.position.xy), group);
        out[group] = select(vec4f(0.0), vec4f(2.0), abs(crossings) > vec4f(0.5));
    }
    return Targets(out[0], out[1], out[2], out[3]);
}

// 1 where a caster was drawn, whatever its depth.
fn covered(drawn: vec4f) -> vec4f {
    return select(vec4f(0.0), vec4f(1.0), drawn > vec4f(0.0));
}

// The coverage of each slice, from depths that were drawn.
@fragment
fn cover(in: Corner) -> Targets {
    var out: array<vec4f, 4>;
    for (var group = 0; group < i32(GROUPS); group++) {
        out[group] = covered(load(vec2i(in.position.xy), group));
    }
    return Targets(out[0], out[1], out[2], out[3]);
}

// The coverage of each slice and all slices before it together.
@fragment
fn unite(in: Corner) -> Targets {
    var out: array<vec4f, 4>;
    var before = 0.0;
    for (var group = 0; group < i32(GROUPS); group++) {
        let slices = covered(load(vec2i(in.position.xy), group));
        let x = max(before, slices.x);
        let y = max(x, slices.y);
        let z = max(y, slices.z);
        before = max(z, slices.w);
        out[group] = vec4f(x, y, z, before);
    }
    return Targets(out[0], out[1], out[2], out[3]);
}

// One step of the sums along one axis. The instance holds the distance of the texels that are added, in its lower 16 bits;
// then whether they stand below each other; then the layer.
@fragment
fn sum(in: Corner) -> @location(0) vec4f {
    let distance = i32(in.instance & 0xffffu);
    let is_down = (in.instance & 0x10000u) != 0u;
    let step = select(vec2i(distance, 0), vec2i(0, distance), is_down);
    let layer = i32(in.instance >> 17u);
    var total = vec4f(0.0);
    for (var index = 0; index < RADIX; index++) {
        total += load(vec2i(in.position.xy) - index * step, layer);
    }
    return total;
}
