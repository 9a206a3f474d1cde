// One light: bind group 1. The light that arrives at a surface, from points, spots, directional lights and
// areas.
// Host    src/render/pools/light_constants.rs, src/render/pools/gpu_types.rs
#define_import_path antumbra::light

#import antumbra::light_shape::LightShape
#import antumbra::area_light::{rect_irradiance, sphere_irradiance, rect_highlight, sphere_highlight}

struct Light {                      // mirror: render::pools::gpu_types::Light
    point_relative: vec4f,          // w = 1: position; w = 0: unit direction towards the light
    emission: vec4f,                // linear RGB times candela or lux; w: 1 / range², 0 without a range
    axis: vec4f,                    // unit direction of shining; w: 1 for a rectangle's cosine, else 0
    cone: vec4f,                    // scale and offset of the spot's falloff; zw unused
    half_right: vec4f,              // half the width of a rectangle, along it; w: radius of a sphere
    half_up: vec4f,                 // half its height, along it; w: 1 for an area light with an extent
    weights: vec4f,                 // of ambient, diffuse and specular light; w: darkness of shadows
    shadow_emission: vec4f,         // emission in shadows, as `emission`; w unused
    shape: LightShape,
}

@group(1) @binding(0) var<uniform> light: Light;

struct Incidence {
    towards: vec3f,                 // unit, from the surface to the light's centre
    irradiance: vec3f,              // on the surface
    highlight: vec3f,               // unit, towards the point of the light that a mirror would show
    highlight_irradiance: vec3f,    // on a plane that faces the highlight
    radius: f32,                    // of the light over its distance; 0 for points
}

// Unit direction from a surface towards the point of the light that it would show if it were a mirror with this normal.
fn highlight_at(position_relative: vec3f, normal: vec3f, to_eye: vec3f) -> vec3f {
    let to_light = light.point_relative.xyz - position_relative * light.point_relative.w;
    let distance = sqrt(max(dot(to_light, to_light), 1e-8));
    let is_rect = light.axis.w > 0.0;
    let mirrored = reflect(-to_eye, normal);
    let on_rect = rect_highlight(to_light, distance, light.half_right.xyz, light.half_up.xyz, light.axis.xyz, mirrored);
    let on_sphere = sphere_highlight(to_light, light.half_right.w, mirrored);
    return select(to_light / distance, normalize(select(on_sphere, on_rect, is_rect)), light.half_up.w > 0.0);
}

// Light that arrives at a surface. For points it is the inverse square of the distance, windowed to reach 0
// at the range, times the spot's cone. For areas it is the integral over the part above the surface's
// horizon; the first two terms of its expansion in the light's size are those of a point.
// Source: Khronos, KHR_lights_punctual; the window is of Karis 2013, "Real Shading in Unreal Engine 4".
fn incidence(position_relative: vec3f, normal: vec3f, to_eye: vec3f) -> Incidence {
    return incidence_of(light.emission.rgb, position_relative, normal, to_eye);
}

// Light that arrives from the same light if it emits as much as `emission`.
fn incidence_of(emission: vec3f, position_relative: vec3f, normal: vec3f, to_eye: vec3f) -> Incidence {
    var out: Incidence;
    let to_light = light.point_relative.xyz - position_relative * light.point_relative.w;
    let distance_sq = max(dot(to_light, to_light), 1e-8);
    let distance = sqrt(distance_sq);
    out.towards = to_light / distance;
    let part = distance_sq * light.emission.w;
    let window = clamp(1.0 - part * part, 0.0, 1.0);
    let attenuation = select(1.0, window / distance_sq, light.point_relative.w > 0.0);
    let cos_axis = dot(-out.towards, light.axis.xyz);
    let cone = clamp(cos_axis * light.cone.x + light.cone.y, 0.0, 1.0);
    let cosine = mix(1.0, max(cos_axis, 0.0), light.axis.w);
    let facing = emission * (attenuation * cone * cone * cosine);

    // Selects instead of branches: lavapipe compiles a shader again for each value of a uniform on which it
    // branches.
    let is_area = light.half_up.w > 0.0;
    let is_rect = light.axis.w > 0.0;
    let right = light.half_right.xyz;
    let up = light.half_up.xyz;
    let radius = select(light.half_right.w, sqrt(length(right) * length(up) * 1.2732395), is_rect);
    let from_rect = rect_irradiance(to_light, distance, right, up, light.axis.xyz, normal);
    let from_sphere = sphere_irradiance(out.towards, distance, light.half_right.w, normal);
    let from_area = emission * (window * select(from_sphere, from_rect, is_rect));
    out.irradiance = select(facing * max(dot(normal, out.towards), 0.0), from_area, is_area);
    out.highlight = highlight_at(position_relative, normal, to_eye);
    out.highlight_irradiance = facing;
    out.radius = select(0.0, radius / distance, is_area);
    return out;
}
