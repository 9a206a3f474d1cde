// Clears the stencil inside one light's scissor and marks the pixels inside its depth bounds.
// Host    src/render/nodes/light_begin.rs
// Groups  none: the depth of the quad is its instance index, read as a float's bits
struct Corner {
    @builtin(position) position_clip: vec4f,
}

@vertex
fn vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) depth_bits: u32) -> Corner {
    // One triangle over the whole target: (−1, −1), (3, −1), (−1, 3).
    let corner = vec2f(f32((vertex & 1u) << 2u), f32((vertex & 2u) << 1u)) - 1.0;
    return Corner(vec4f(corner, bitcast<f32>(depth_bits), 1.0));
}

// Writes nothing: the colour target's write mask is empty.
@fragment
fn no_color() -> @location(0) vec4f {
    return vec4f(0.0);
}
