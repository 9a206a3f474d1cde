// From accumulated radiance to the display.
// Host    src/render/nodes/tonemap.rs
// Groups  3 the pass's own
#import antumbra::conventions::RADIANCE_MAX

@group(3) @binding(0) var radiance_texture: texture_2d<f32>;
@group(3) @binding(1) var<uniform> exposure: vec4f; // x: factor on radiance; yzw unused

// Keeps hue and the colours of well-lit surfaces, compresses only highlights.
// Source: Khronos 2024, "Khronos PBR Neutral Tone Mapper", formula of its specification.
fn pbr_neutral(radiance: vec3f) -> vec3f {
    let start = 0.8 - 0.04;
    let desaturation = 0.15;
    let lowest = min(radiance.r, min(radiance.g, radiance.b));
    let offset = select(0.04, lowest - 6.25 * lowest * lowest, lowest < 0.08);
    let color = radiance - offset;
    let peak = max(color.r, max(color.g, color.b));
    if peak < start {
        return color;
    }
    let room = 1.0 - start;
    let compressed = 1.0 - room * room / (peak + room - start);
    let grey = 1.0 - 1.0 / (desaturation * (peak - compressed) + 1.0);
    return mix(color * (compressed / peak), vec3f(compressed), grey);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let radiance = textureLoad(radiance_texture, vec2u(position.xy), 0).rgb;
    let shown = min(max(radiance, vec3f(0.0)) * exposure.x, vec3f(RADIANCE_MAX)); // the sum of lights may be infinite
    return vec4f(pbr_neutral(shown), 1.0);
}
