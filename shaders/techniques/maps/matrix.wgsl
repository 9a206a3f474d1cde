// Faces with a matrix: which of them shows a point, how large its texels are there, and the depth of a plane.
// Host    src/techniques/maps/gpu/constants.rs
// Spaces  relative: world axes, origin at the eye; clip of a face: reversed depth
// Twin    techniques::maps::matrix_faces, held equal by tests/gpu/maps/matrix_twins.rs
//
// The third column of `relative_from_clip` is the light as a homogeneous point, scaled by a positive number: all
// rays of light meet there. A plane, a row vector, times the matrix is the plane in clip space.
#define_import_path antumbra::map_matrix

#import antumbra::map::map_light

const NO_FACE: u32 = 6u;

fn clip_in_face(face: u32, position: vec3f) -> vec4f {
    return map_light.faces[face].clip_from_relative * vec4f(position, 1.0);
}

// The face in which a point is farthest from the border.
fn showing(position: vec3f) -> u32 {
    var best = NO_FACE;
    var nearest = 1.0;
    for (var face = 0u; face < u32(map_light.size.w); face++) {
        let clip = clip_in_face(face, position);
        let border = max(abs(clip.x), abs(clip.y)) / clip.w;
        let shows = clip.w > 0.0 && border <= nearest;
        best = select(best, face, shows);
        nearest = select(nearest, border, shows);
    }
    return best;
}

// Unit direction of the light's ray at a point.
fn ray_at(face: u32, position: vec3f) -> vec3f {
    let light = map_light.faces[face].relative_from_clip[2];
    let from_light = position * light.w - light.xyz;
    // The components may be too large or too small for their squares.
    let largest = max(max(abs(from_light.x), abs(from_light.y)), max(abs(from_light.z), 1e-37));
    return normalize(from_light / largest);
}

// A side of a texel at a point, metres, at right angles to the ray; `axis` 0: to the right, 1: up.
// Source: Kozlov 2004, GPU Gems ch. 14, §14.2.3.
fn texel_side(face: u32, axis: u32, position: vec3f, w: f32, ray: vec3f) -> vec3f {
    let column = map_light.faces[face].relative_from_clip[axis];
    let step = (column.xyz - position * column.w) * (w * 2.0 * map_light.size.y);
    return step - ray * dot(ray, step);
}

// A plane `dot(normal, point) = offset` in the clip space of a face. Where its third component is greater
// than 0, its front faces the light, and its depth is linear in NDC.
fn plane_in_face(face: u32, normal: vec3f, offset: f32) -> vec4f {
    return vec4f(normal, -offset) * map_light.faces[face].relative_from_clip;
}

// Fall of depth from a point, given in clip space, along a short step away from the light.
fn depth_step(face: u32, clip: vec4f, step: vec3f) -> f32 {
    let change = map_light.faces[face].clip_from_relative * vec4f(step, 0.0);
    return (clip.z / clip.w * change.w - change.z) / clip.w;
}
