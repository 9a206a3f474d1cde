// Barn doors and distances: the share of a light that its shape lets pass towards a point.
// Host    src/render/light_model/constants.rs, src/render/pools/gpu_types.rs
// Twin    scene::light_model, held equal by tests/gpu/light_model
// Spaces  relative: world axes, origin at the eye
//         light: x and y across, z the depth in front of the light
#define_import_path antumbra::light_shape

struct LightShape {                 // mirror: render::pools::gpu_types::LightShape
    light_from_relative_x: vec4f,   // rows of the affine matrix
    light_from_relative_y: vec4f,
    light_from_relative_z: vec4f,
    semi_axes: vec4f,               // of the region of full intensity in xy, of the whole region in zw
    distance: vec4f,                // depth where it fades in, 1 / edge; depth where it fades out, 1 / edge
    form: vec4f,                    // exponent, its inverse; 1 with barn doors; 1 if the inner region has an area
}

// Largest radius of the superellipse.
const LARGEST_RADIUS: f32 = 1e8;

fn light_position(position_relative: vec3f, shape: LightShape) -> vec3f {
    let p = vec4f(position_relative, 1.0);
    return vec3f(
        dot(shape.light_from_relative_x, p),
        dot(shape.light_from_relative_y, p),
        dot(shape.light_from_relative_z, p),
    );
}

// The factor by which the superellipse must grow to pass through a point of the first quadrant.
fn superellipse_radius(at: vec2f, semi_axes: vec2f, exponent: f32, inverse_exponent: f32) -> f32 {
    let relative = min(at / max(semi_axes, vec2f(1e-12)), vec2f(LARGEST_RADIUS));
    let longest = max(relative.x, relative.y);
    let ratio = max(min(relative.x, relative.y) / max(longest, 1e-20), 1e-20);
    return min(longest * pow(1.0 + pow(ratio, exponent), inverse_exponent), LARGEST_RADIUS);
}

fn smooth_edge(t: f32) -> f32 {
    let s = clamp(t, 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

// Share of the light that passes the doors towards a place on the plane one metre before the light, 0 to 1. The place is
// in the first quadrant.
// Source: Pellacini & Vidimce 2004, "Cinematic Lighting", GPU Gems ch. 10, listing 10-2; the superellipse as a
// radius, which has no singular point, is ours.
fn doors_factor(at: vec2f, shape: LightShape) -> f32 {
    let in_radius = superellipse_radius(at, shape.semi_axes.xy, shape.form.x, shape.form.y);
    let inner = select(LARGEST_RADIUS, in_radius, shape.form.w > 0.0);
    let outer = superellipse_radius(at, shape.semi_axes.zw, shape.form.x, shape.form.y);
    return 1.0 - smooth_edge((inner - 1.0) * outer / max(inner - outer, 1e-20));
}

// How far the light has faded in, and how far it has faded out, at the depth of a point. Source: as `doors_factor`.
fn depth_fades(position: vec3f, shape: LightShape) -> vec2f {
    let depth = select(length(position), position.z, shape.form.z > 0.0);
    return vec2f(
        smooth_edge((depth - shape.distance.x) * shape.distance.y),
        smooth_edge((depth - shape.distance.z) * shape.distance.w),
    );
}

// Share of the light that passes, 0 to 1. It is 1 without a shape and without distances.
fn shape_factor(position: vec3f, shape: LightShape) -> f32 {
    let passed = doors_factor(abs(position.xy) / max(position.z, 1e-20), shape);
    let doors = select(1.0, select(0.0, passed, position.z > 0.0), shape.form.z > 0.0);
    let fades = depth_fades(position, shape);
    return doors * fades.x * (1.0 - fades.y);
}
