// The visibility mask of one light: bind group 3 of the passes that read it.
// Host    src/render/gpu/bind_groups.rs, src/render/frame/targets.rs
#define_import_path antumbra::mask

@group(3) @binding(0) var mask: texture_2d<f32>;

// Share of the light that the surface at a pixel sees, 0..=1: rgb by colour, a by area of the emitter.
fn visibility(pixel: vec2f) -> vec4f {
    return textureLoad(mask, vec2u(pixel), 0);
}
