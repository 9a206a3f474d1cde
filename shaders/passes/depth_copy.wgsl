// The frame's depth as a colour, so that passes can read it while they write the stencil beside it.
// Host    src/render/nodes/depth_copy.rs
// Groups  3 the pass's own
@group(3) @binding(0) var depth_texture: texture_depth_2d;

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(textureLoad(depth_texture, vec2u(position.xy), 0));
}
