// Covers the whole target with one triangle: (−1, −1), (3, −1), (−1, 3).
// Host    src/render/gpu/pipeline_cache.rs
// Groups  none

fn corner(vertex: u32) -> vec2f {
    return vec2f(f32((vertex & 1u) << 2u), f32((vertex & 2u) << 1u)) - 1.0;
}

@vertex
fn everywhere(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    return vec4f(corner(vertex), 0.0, 1.0);
}

// The instance index holds the bits of the depth.
@vertex
fn at_depth(@builtin(vertex_index) vertex: u32, @builtin(instance_index) depth_bits: u32) -> @builtin(position) vec4f {
    return vec4f(corner(vertex), bitcast<f32>(depth_bits), 1.0);
}

struct Corner {
    @builtin(position) position_clip: vec4f,
    @location(0) @interpolate(flat) instance: u32,
}

@vertex
fn with_instance(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
    return Corner(vec4f(corner(vertex), 0.0, 1.0), instance);
}
