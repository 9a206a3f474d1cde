// The frame's depth as a colour, so that passes can read it while they write the stencil beside it.
// Host    src/render/nodes/depth_copy.rs
// Groups  3 the pass's own
@group(3) @binding(0) var depth_texture: texture_depth_2d;

@vertex
fn vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32((vertex & 1u) << 2u), f32((vertex & 2u) << 1u)) - 1.0;
    return vec4f(corner, 0.0, 1.0);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(textureLoad(depth_texture, vec2u(position.xy), 0));
}
