// The visibility mask of one light: bind group 3 of the passes that read it.
// Host    src/render/bind_groups.rs, src/render/targets.rs
#define_import_path antumbra::mask

@group(3) @binding(0) var mask: texture_2d<f32>;

// Share of the light that the surface at a pixel sees: by colour in rgb, of the emitter's area in a; 0..=1.
fn visibility(pixel: vec2f) -> vec4f {
    return textureLoad(mask, vec2u(pixel), 0);
}
