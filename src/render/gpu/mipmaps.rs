//! Mipmaps of 8-bit textures, averaged in linear light.

use image::imageops::FilterType;
use image::{ImageBuffer, Rgba, Rgba32FImage};

use crate::scene::Texture;

/// A texture with its mip levels, largest first, stored one after the other.
#[derive(Debug)]
pub struct MipChain {
    /// Width of the first level, texels.
    pub width: u32,
    /// Height of the first level, texels.
    pub height: u32,
    /// The number of levels down to 1×1.
    pub levels: u32,
    /// The texels of all levels, four bytes each.
    pub rgba8: Vec<u8>,
}

/// Builds the mip levels of a texture. If the texture is larger than `limit` texels along a side, the chain
/// begins at the first level that fits.
pub fn mip_chain(texture: &Texture, srgb: bool, limit: u32) -> MipChain {
    let (mut width, mut height) = (texture.width, texture.height);
    let mut level: Rgba32FImage = ImageBuffer::from_fn(width, height, |x, y| {
        let at = 4 * (y as usize * width as usize + x as usize);
        let texel: [u8; 4] = std::array::from_fn(|channel| texture.rgba8[at + channel]);
        Rgba(decode(texel, srgb))
    });
    let mut chain = MipChain {
        width: 0,
        height: 0,
        levels: 0,
        rgba8: Vec::with_capacity(texture.rgba8.len() * 4 / 3 + 4),
    };
    loop {
        if width <= limit && height <= limit {
            if chain.levels == 0 {
                (chain.width, chain.height) = (width, height);
            }
            chain.levels += 1;
            chain
                .rgba8
                .extend(level.pixels().flat_map(|texel| encode(texel.0, srgb)));
        }
        if width == 1 && height == 1 {
            return chain;
        }
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
        level = image::imageops::resize(&level, width, height, FilterType::Triangle);
    }
}

/// Decodes a texel to linear light.
///
/// Source: IEC 61966-2-1, the sRGB transfer function.
fn decode(texel: [u8; 4], srgb: bool) -> [f32; 4] {
    let mut out = texel.map(|byte| f32::from(byte) / 255.0);
    if srgb {
        for channel in &mut out[..3] {
            *channel = if *channel <= 0.04045 {
                *channel / 12.92
            } else {
                ((*channel + 0.055) / 1.055).powf(2.4)
            };
        }
    }
    out
}

fn encode(mut texel: [f32; 4], srgb: bool) -> [u8; 4] {
    if srgb {
        for channel in &mut texel[..3] {
            *channel = if *channel <= 0.003_130_8 {
                *channel * 12.92
            } else {
                1.055 * channel.powf(1.0 / 2.4) - 0.055
            };
        }
    }
    texel.map(|channel| (channel.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)
}
