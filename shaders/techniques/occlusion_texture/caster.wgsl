// Casters in one drawing into all slices: four colour targets with a slice in each channel. The depth of a fragment chooses
// the channel; blending keeps the maximum.
// Host    src/techniques/occlusion_texture/gpu/pipelines.rs
// Groups  0 casters, 1 face, 2 material (`masked` alone)
// Spaces  in: local; out: clip of the picture, whose third coordinate is depth in light space before it leaves the vertex
//         stage
#import antumbra::map_caster::clip_position
#import antumbra::surface::{Fragment, base_color, material}
#import antumbra::occlusion_kernel::OcclusionFace

@group(1) @binding(0) var<uniform> face: OcclusionFace;

// Whether casters fill the next slice too.
override CLOSE: bool = false;
// Whether depths are drawn: 2 at the top of a slice, down to 1 at its end, so that the nearest caster is kept.
override DEPTHS: bool = false;

struct Solid {
    @builtin(position) position_clip: vec4f,
    @location(0) depth: f32,
}

struct Masked {
    @builtin(position) position_clip: vec4f,
    @location(0) depth: f32,
    @location(1) uv: vec4f,
    @location(2) color: vec4f,
}

struct Slices {
    @location(0) a: vec4f,
    @location(1) b: vec4f,
    @location(2) c: vec4f,
    @location(3) d: vec4f,
}

// Nothing is clipped by depth.
fn flattened(place: vec4f) -> vec4f {
    return vec4f(place.xy, 0.5 * place.w, place.w);
}

@vertex
fn solid_vertex(@location(0) position_local: vec3f, @builtin(instance_index) caster: u32) -> Solid {
    let place = clip_position(position_local, caster);
    return Solid(flattened(place), place.z);
}

@vertex
fn masked_vertex(
    @location(0) position_local: vec3f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    @builtin(instance_index) caster: u32,
) -> Masked {
    let place = clip_position(position_local, caster);
    return Masked(flattened(place), place.z, uv, color);
}

// Values for the channels of the slices that hold the depth. Slices that are filled too begin at `first`.
fn channels(depth: f32, first: vec4f, tops: vec4f, bottoms: vec4f) -> vec4f {
    var value = vec4f(1.0);
    if DEPTHS {
        value = 2.0 - clamp((depth - tops) / max(bottoms - tops, vec4f(1e-30)), vec4f(0.0), vec4f(1.0));
    }
    return select(vec4f(0.0), value, (vec4f(depth) > first) & (vec4f(depth) <= bottoms));
}

fn slices_at(depth: f32) -> Slices {
    var before = vec2f(face.depth.z);   // ends of the two slices before a group
    var out: array<vec4f, 4>;
    for (var group = 0; group < 4; group++) {
        let bottoms = face.bottoms[group];
        let tops = vec4f(before.y, bottoms.xyz);
        // A slice that is filled by the one before begins where that one begins.
        out[group] = channels(depth, select(tops, vec4f(before, bottoms.xy), CLOSE), tops, bottoms);
        before = bottoms.zw;
    }
    return Slices(out[0], out[1], out[2], out[3]);
}

@fragment
fn solid(in: Solid) -> Slices {
    return slices_at(in.depth);
}

// Counts the surfaces of closed casters before the top of each slice: 1 for a front and -1 for a back. Where the sum is not 0, the
// top lies inside of a caster.
@fragment
fn crossings(in: Solid, @builtin(front_facing) is_front: bool) -> Slices {
    let crossing = vec4f(select(-1.0, 1.0, is_front));
    var before = face.depth.z;          // end of the slice before a group
    var out: array<vec4f, 4>;
    for (var group = 0; group < 4; group++) {
        let bottoms = face.bottoms[group];
        out[group] = select(vec4f(0.0), crossing, vec4f(in.depth) <= vec4f(before, bottoms.xyz));
        before = bottoms.w;
    }
    return Slices(out[0], out[1], out[2], out[3]);
}

@fragment
fn masked(in: Masked) -> Slices {
    var surface: Fragment;
    surface.uv = in.uv;
    surface.color = in.color;
    if base_color(surface).a < material.alpha_cutoff {
        discard;
    }
    return slices_at(in.depth);
}
