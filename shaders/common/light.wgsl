// One light: bind group 1.
// Host    src/render/lights.rs, src/render/gpu_types.rs
#define_import_path antumbra::light

struct Light {                      // mirror: render::gpu_types::Light
    point_relative: vec4f,          // w = 1: position; w = 0: unit direction towards the light
    emission: vec4f,                // linear RGB times candela or lux; w: 1 / range², 0 without one
    axis: vec4f,                    // unit direction of shining; w: 1 for a rectangle's cosine, else 0
    cone: vec4f,                    // scale and offset of the spot's falloff; zw unused
}

@group(1) @binding(0) var<uniform> light: Light;

struct Incidence {
    towards: vec3f,                 // unit, from the surface to the light
    irradiance: vec3f,              // on a plane that faces the light
}

// Inverse square, windowed to reach 0 at the range, and the spot's cone.
// Source: Khronos, KHR_lights_punctual; the window is of Karis 2013, "Real Shading in Unreal Engine 4".
fn incidence(position_relative: vec3f) -> Incidence {
    var out: Incidence;
    let to_light = light.point_relative.xyz - position_relative * light.point_relative.w;
    let distance_sq = max(dot(to_light, to_light), 1e-8);
    out.towards = to_light * inverseSqrt(distance_sq);
    let part = distance_sq * light.emission.w;
    let window = clamp(1.0 - part * part, 0.0, 1.0);
    let attenuation = select(1.0, window / distance_sq, light.point_relative.w > 0.0);
    let cos_axis = dot(-out.towards, light.axis.xyz);
    let cone = clamp(cos_axis * light.cone.x + light.cone.y, 0.0, 1.0);
    let cosine = mix(1.0, max(cos_axis, 0.0), light.axis.w);
    out.irradiance = light.emission.rgb * (attenuation * cone * cone * cosine);
    return out;
}
