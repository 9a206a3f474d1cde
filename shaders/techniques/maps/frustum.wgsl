// Edges of the volumes that a map's faces show, drawn over the picture: the debug view.
// Host    src/techniques/maps/gpu/pipelines.rs
// Groups  0 casters: for each face, the matrix to the view's clip space from the cube [−1, 1]² × [0, 1]
#import antumbra::map_caster::clip_position

struct End {
    @builtin(position) position_clip: vec4f,
    @location(0) color: vec3f,
}

// Vertices 0..24 are the ends of twelve edges. The bits of a corner are right, top, near.
@vertex
fn edge(@builtin(vertex_index) vertex: u32, @builtin(instance_index) face: u32) -> End {
    let index = vertex / 2u;
    let axis = index / 4u;
    let others = index % 4u;
    let low = others & ((1u << axis) - 1u);
    let high = (others >> axis) << (axis + 1u);
    let corner = low | high | ((vertex & 1u) << axis);
    let x = f32(corner & 1u) * 2.0 - 1.0;
    let y = f32((corner >> 1u) & 1u) * 2.0 - 1.0;
    let z = f32(corner >> 2u);
    let hue = f32(face % 6u) / 6.0;
    let color = clamp(abs(fract(vec3f(hue, hue + 0.667, hue + 0.333)) * 6.0 - 3.0) - 1.0, vec3f(0.0), vec3f(1.0));
    return End(clip_position(vec3f(x, y, z), face), color);
}

@fragment
fn line(in: End) -> @location(0) vec4f {
    return vec4f(in.color, 0.0);
}
