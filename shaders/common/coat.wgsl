// A clearcoat over a drawn surface, lit by one light.
// Groups  0 view, 1 light, 2 material
#define_import_path antumbra::coat

#import antumbra::surface::{Fragment, clearcoat, smooth_normal}
#import antumbra::light::{Incidence, highlight_at}
#import antumbra::brdf::{Reflected, coat_share, coated}

// Radiance of a surface below its coat and of the coat, and the share of the light that the coat reflects.
struct CoatedSurface {
    parts: Reflected,
    share: f32,
}

// Covers a surface that reflects `base` with its coat. The coat is smooth and shows a point of the light of its own.
fn with_coat(base: Reflected, in: Fragment, front_facing: bool, towards_eye: vec3f, arriving: Incidence) -> CoatedSurface {
    let coat = clearcoat(in);
    let normal = smooth_normal(in, front_facing);
    let share = coat_share(coat.x, normal, towards_eye);
    let parts = coated(
        base,
        share,
        coat.y,
        normal,
        towards_eye,
        highlight_at(in.position_relative, normal, towards_eye),
        arriving.highlight_irradiance,
        arriving.radius,
    );
    return CoatedSurface(parts, share);
}
