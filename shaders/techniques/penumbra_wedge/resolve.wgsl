// From sums to visibility: what one part of a light adds to the mask. Its share of the light is the blend constant.
// Host    src/techniques/penumbra_wedge/node.rs
// Groups  3 the visibility buffer
@group(3) @binding(0) var facing_sums: texture_2d<f32>;         // or what was added, in four bytes
@group(3) @binding(1) var facing_subtracted: texture_2d<f32>;
@group(3) @binding(2) var combined: texture_2d<f32>;            // coverage of the groups before
@group(3) @binding(3) var<storage, read_write> overflow: atomic<u32>;
@group(3) @binding(4) var averted_sums: texture_2d<f32>;
@group(3) @binding(5) var averted_subtracted: texture_2d<f32>;

// The sums are four bytes each way.
override IS_SPLIT: bool = false;
// There is one sum for all colours.
override IS_SCALAR: bool = false;
// The coverage of groups was combined.
override IS_COMBINED: bool = false;

@vertex
fn vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32((vertex & 1u) << 2u), f32((vertex & 2u) << 1u)) - 1.0;
    return vec4f(corner, 0.0, 1.0);
}

fn joined(added: vec4f, subtracted: vec4f) -> vec4f {
    if IS_SPLIT {
        let weights = vec4f(512.0, 64.0, 8.0, 1.0) * (255.0 / 4096.0);
        // A byte that is full may have lost a carry.
        if any(max(added, subtracted) >= vec4f(1.0)) {
            atomicAdd(&overflow, 1u);
        }
        return vec4f(dot(added - subtracted, weights));
    }
    return select(added, added.rrrr, IS_SCALAR);
}

// What the layer that hides more leaves.
fn visible(pixel: vec2u) -> vec4f {
    let facing = joined(textureLoad(facing_sums, pixel, 0), textureLoad(facing_subtracted, pixel, 0));
    let averted = joined(textureLoad(averted_sums, pixel, 0), textureLoad(averted_subtracted, pixel, 0));
    return clamp(1.0 + min(facing, averted), vec4f(0.0), vec4f(1.0));
}

@fragment
fn resolve(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    if IS_COMBINED {
        return 1.0 - min(textureLoad(combined, pixel, 0), vec4f(1.0));
    }
    return visible(pixel);
}

// Coverage between the extremes of no and all overlap.
// Source: Assarsson et al. 2003, equation 1.
@fragment
fn combine(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    let before = textureLoad(combined, pixel, 0);
    let now = 1.0 - visible(pixel);
    return max(before, now) + 0.5 * min(before, now);
}
