// The radiance that one light adds to the surfaces of its set I.
// Host    src/render/nodes/light_accumulate.rs
// Groups  0 view, 1 light, 2 material; `masked` also 3 mask, `behind_front` 3 front depth
#import antumbra::surface::{VertexIn, Fragment, surface_vertex, base_color, metallic_roughness, shading_normal}
#import antumbra::view::to_eye
#import antumbra::light::incidence
#import antumbra::brdf::reflected_parts
#import antumbra::coat::with_coat
#import antumbra::conventions::RADIANCE_MAX
#import antumbra::mask::visibility
#import antumbra::front::is_front

override BLENDED: bool = false;
// The material has a clearcoat.
override COATED: bool = false;

@vertex
fn vertex(in: VertexIn) -> Fragment {
    return surface_vertex(in);
}

// Radiance that the light adds to a surface that sees the whole light.
fn lit(in: Fragment, front_facing: bool) -> vec4f {
    let color = base_color(in);
    let mr = metallic_roughness(in);
    let normal = shading_normal(in, front_facing);
    let towards_eye = to_eye(in.position_relative);
    let arriving = incidence(in.position_relative, normal, towards_eye);
    var parts = reflected_parts(
        color.rgb,
        mr.x,
        mr.y,
        normal,
        towards_eye,
        arriving.towards,
        arriving.irradiance,
        arriving.highlight,
        arriving.highlight_irradiance,
        arriving.radius,
    );
    if COATED {
        parts = with_coat(parts, in, front_facing, towards_eye, arriving).parts;
    }
    let radiance = parts.diffuse + parts.specular;
    let alpha = select(1.0, color.a, BLENDED);
    let added = min(radiance, vec3f(RADIANCE_MAX)); // infinity would spread
    return vec4f(added * alpha, 0.0);
}

@fragment
fn fragment(in: Fragment, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    return lit(in, front_facing);
}

@fragment
fn masked(in: Fragment, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    let seen = visibility(in.position_clip.xy).rgb;
    return lit(in, front_facing) * vec4f(seen, 1.0);
}

// Lights surfaces behind the nearest blended surface. That surface is lit in a pass of its own.
@fragment
fn behind_front(in: Fragment, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    let radiance = lit(in, front_facing);
    if is_front(in.position_clip) {
        discard;
    }
    return radiance;
}
