// The factors of light functions, for lights whose shadows have a colour: in bind group 3, beside the mask.
// Host    src/render/gpu/bind_groups.rs, src/render/frame/targets.rs
#define_import_path antumbra::factors

@group(3) @binding(1) var factor_mask: texture_2d<f32>;

// Share of the light that functions let pass to the surface at a pixel, by colour.
fn factors(pixel: vec2f) -> vec3f {
    return textureLoad(factor_mask, vec2u(pixel), 0).rgb;
}
