//! Textures that the import computes from those of the file, texel by texel.

use std::sync::Arc;

use glam::{Vec3, Vec4};

use crate::scene::{Texture, TextureSlot, srgb};

/// Whether two textures cover a surface in the same way, so that they can be combined texel by texel.
pub(super) fn are_aligned(a: &TextureSlot, b: &TextureSlot) -> bool {
    a.uv_set == b.uv_set && a.uv_transform == b.uv_transform && a.texture.wrap == b.texture.wrap
}

/// The grid of the slots that are present: the size of the largest texture, and a slot to sample the result by.
pub(super) fn grid(slots: [Option<&TextureSlot>; 2]) -> Option<&TextureSlot> {
    let texels = |slot: &&TextureSlot| u64::from(slot.texture.width) * u64::from(slot.texture.height);
    slots.into_iter().flatten().max_by_key(texels)
}

/// A texture of the same size and sampler as that of `like`, whose texels are computed by `texel` from the column and
/// the row.
pub(super) fn texture(
    like: &TextureSlot,
    name: String,
    mut texel: impl FnMut(u32, u32) -> [u8; 4],
) -> TextureSlot {
    let Texture { width, height, .. } = *like.texture;
    let mut rgba8 = Vec::with_capacity(like.texture.rgba8.len());
    for y in 0..height {
        for x in 0..width {
            rgba8.extend(texel(x, y));
        }
    }
    TextureSlot {
        texture: Arc::new(Texture {
            name,
            width,
            height,
            rgba8,
            wrap: like.texture.wrap,
            linear_magnify: like.texture.linear_magnify,
            linear_minify: like.texture.linear_minify,
        }),
        uv_set: like.uv_set,
        uv_transform: like.uv_transform,
    }
}

/// The texel of a slot at a texel of a grid of another size; white without a slot.
pub(super) fn texel(slot: Option<&TextureSlot>, grid: &TextureSlot, x: u32, y: u32) -> [u8; 4] {
    let Some(texture) = slot.map(|slot| &slot.texture) else {
        return [255; 4];
    };
    let along = |at: u32, size: u32, of: u32| (u64::from(at) * u64::from(size) / u64::from(of)) as usize;
    let column = along(x, texture.width, grid.texture.width);
    let row = along(y, texture.height, grid.texture.height);
    let start = 4 * (row * texture.width as usize + column);
    texture
        .rgba8
        .get(start..start + 4)
        .map_or([255; 4], |bytes| [bytes[0], bytes[1], bytes[2], bytes[3]])
}

/// The linear colour of an sRGB texel, and its alpha.
pub(super) fn linear([r, g, b, a]: [u8; 4]) -> Vec4 {
    Vec4::new(
        srgb::decode(r),
        srgb::decode(g),
        srgb::decode(b),
        f32::from(a) / 255.0,
    )
}

/// The sRGB texel of a linear colour and an alpha.
pub(super) fn encoded(color: Vec3, alpha: f32) -> [u8; 4] {
    [
        srgb::encode(color.x),
        srgb::encode(color.y),
        srgb::encode(color.z),
        byte(alpha),
    ]
}

/// The byte of a number that is not a colour.
pub(super) fn byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// The mean of an sRGB texture in linear light; white without a slot.
pub(super) fn mean(slot: Option<&TextureSlot>) -> Vec4 {
    let Some(texture) = slot.map(|slot| &slot.texture) else {
        return Vec4::ONE;
    };
    let texels = texture.rgba8.as_chunks::<4>().0;
    let sum = texels
        .iter()
        .fold(glam::DVec4::ZERO, |sum, &texel| sum + linear(texel).as_dvec4());
    (sum / texels.len().max(1) as f64).as_vec4()
}
