// Whether triangles have their front towards a light, as receivers see the light through them.
// Host    src/techniques/penumbra_wedge/geometry/silhouette_layers.rs
// Spaces  light
#define_import_path antumbra::wedge_faces

#import antumbra::receiver::Receiver
#import antumbra::wedge_light::{light, direction_in_light}

// A receiver's position relative to the planes of triangles.
struct Foot {
    p: vec3f,
    normal: vec3f,                  // of the receiver's own triangle, light space
    rounding: f32,                  // distance below which a point counts as in a plane
}

fn foot_of(receiver: Receiver, p: vec3f) -> Foot {
    const ROUNDING: f32 = 4e-6;
    return Foot(p, direction_in_light(receiver.normal), ROUNDING * (length(receiver.position) + length(p)));
}

// Share of the light's extent by which its centre is clear of a plane.
const CLEAR: f32 = 0.1;
// Cosine of the angle within which two normals count as parallel.
const PARALLEL: f32 = 0.9999;

// For each layer, whether the triangle beside an edge has its front towards the light that is seen through
// it. A plane of 0 means that there is no triangle; it stands for a non-facing triangle in the facing layer,
// and a facing one in the averted.
//
// The receiver's own triangle, and any triangle in its plane, hides nothing from the receiver. If the light's
// centre is behind the plane, the hard shadow counts the triangle, so it counts here too, as seen from the
// centre. If the centre is clearly in front of the plane, the triangle belongs to no layer. In between, the
// hard shadow's faces pass so close to the receiver that they may be counted, so the triangle counts as seen
// from the centre again.
fn faces(plane: vec4f, foot: Foot) -> vec2f {
    let value = dot(plane.xyz, foot.p) + plane.w;
    let cosine = dot(plane.xyz, foot.normal);
    let is_own = abs(cosine) > PARALLEL && abs(value) < foot.rounding;
    let is_clear = cosine * plane.w > CLEAR * max(light.half_size.x, light.half_size.y);
    let from_center = vec2f(select(0.0, 1.0, plane.w > 0.0));
    let seen = select(vec2f(select(0.0, 1.0, value < 0.0)), from_center, is_own);
    let is_none = all(plane == vec4f(0.0));
    return select(seen, vec2f(0.0, 1.0), is_none || (is_own && (is_clear || plane.w == 0.0)));
}
