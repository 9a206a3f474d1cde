//! Mipmaps of 8-bit textures, averaged in linear light on all threads.
//!
//! Each level halves the one before by a tent over two texels to each side, first along columns and then along rows. It
//! works on bands of rows: of the first level, which is the largest, only the rows that a band needs are decoded, so
//! that it never exists as numbers. Between levels nothing is rounded to bytes.
//!
//! To decode ten pictures of 2048 × 2048, 42 million texels, to make their mipmaps and to draw them takes `examples/render`
//! 1.0 s of CPU time in all, in the profile of the tests. The results are those of the resampling in the `image` crate,
//! bit for bit.

use glam::Vec4;

use crate::scene::{Texture, srgb, tasks};

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

/// Number of texels of a band. A band takes about a millisecond, which is much longer than handing it to a thread.
const BAND_TEXELS: usize = 1 << 16;

/// Builds the mip levels of a texture. If the texture is larger than `limit` texels along a side, the chain
/// begins at the first level that fits.
pub fn mip_chain(texture: &Texture, srgb: bool, limit: u32) -> MipChain {
    let encoding = Encoding::new(srgb);
    let (mut width, mut height) = (texture.width, texture.height);
    let mut chain = MipChain {
        width: 0,
        height: 0,
        levels: 0,
        rgba8: Vec::with_capacity(texture.rgba8.len() * 4 / 3 + 4),
    };
    let mut level = Level::Bytes(texture.rgba8.as_chunks().0, &encoding);
    loop {
        if width <= limit && height <= limit {
            if chain.levels == 0 {
                (chain.width, chain.height) = (width, height);
            }
            chain.levels += 1;
            level.append_to(&mut chain.rgba8, &encoding);
        }
        if width == 1 && height == 1 {
            return chain;
        }
        let smaller = ((width / 2).max(1), (height / 2).max(1));
        let size = |(width, height): (u32, u32)| [width as usize, height as usize];
        level = Level::Values(halved(&level, size((width, height)), size(smaller)));
        (width, height) = smaller;
    }
}

/// The size of the level of a texture at which a [`mip_chain`] begins.
pub fn size_within([mut width, mut height]: [u32; 2], limit: u32) -> [u32; 2] {
    while width.max(height) > limit.max(1) {
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
    }
    [width, height]
}

/// The linear value of each byte, and how values become bytes.
struct Encoding {
    decoded: [f32; 256],
    srgb: Option<srgb::Encoder>,
}

impl Encoding {
    fn new(is_srgb: bool) -> Self {
        Self {
            decoded: if is_srgb {
                *srgb::decoded()
            } else {
                std::array::from_fn(|byte| byte as f32 / 255.0)
            },
            srgb: is_srgb.then(srgb::Encoder::default),
        }
    }

    fn decode(&self, [r, g, b, a]: [u8; 4]) -> Vec4 {
        let [r, g, b] = [r, g, b].map(|byte| self.decoded[usize::from(byte)]);
        Vec4::new(r, g, b, f32::from(a) / 255.0)
    }

    fn encode(&self, value: Vec4) -> [u8; 4] {
        let linear = |channel: f32| (channel.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        let [r, g, b, a] = value.to_array();
        match self.srgb {
            Some(srgb) => [srgb.encode(r), srgb.encode(g), srgb.encode(b), linear(a)],
            None => [r, g, b, a].map(linear),
        }
    }
}

/// A level: the bytes of the texture itself, or linear values.
enum Level<'t> {
    Bytes(&'t [[u8; 4]], &'t Encoding),
    Values(Vec<Vec4>),
}

impl Level<'_> {
    fn append_to(&self, rgba8: &mut Vec<u8>, encoding: &Encoding) {
        let values = match self {
            Self::Bytes(texels, _) => return rgba8.extend_from_slice(texels.as_flattened()),
            Self::Values(values) => values,
        };
        let before = rgba8.len();
        rgba8.resize(before + 4 * values.len(), 0);
        let bands = rgba8[before..]
            .chunks_mut(4 * BAND_TEXELS)
            .zip(values.chunks(BAND_TEXELS));
        tasks::for_each_on_all_threads(bands, values.len() > BAND_TEXELS, |(bytes, values)| {
            for (texel, &value) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(values) {
                *texel = encoding.encode(value);
            }
        });
    }

    /// The linear values of a row. Those of bytes are decoded into `decoded`.
    fn row<'r>(&'r self, row: usize, width: usize, decoded: &'r mut Vec<Vec4>) -> &'r [Vec4] {
        let range = row * width..(row + 1) * width;
        match self {
            Self::Values(values) => &values[range],
            Self::Bytes(texels, encoding) => {
                decoded.clear();
                decoded.extend(texels[range].iter().map(|&texel| encoding.decode(texel)));
                decoded
            }
        }
    }
}

/// The texels that an output texel averages along one axis, and their weights, which have the sum 1.
struct Taps {
    first: usize,
    weights: smallvec::SmallVec<[f32; 6]>,
}

/// The taps of each output texel along an axis. Source: the resampling by a triangle of the crate `image`, which this
/// repeats operation by operation.
fn taps(from: usize, to: usize) -> Vec<Taps> {
    let ratio = from as f32 / to as f32;
    let of_texel = |texel: usize| {
        let center = (texel as f32 + 0.5) * ratio;
        let first = ((center - ratio).floor() as i64).clamp(0, from as i64 - 1);
        let end = ((center + ratio).ceil() as i64).clamp(first + 1, from as i64);
        let center = center - 0.5;
        let mut weights: smallvec::SmallVec<[f32; 6]> = (first..end)
            .map(|tap| {
                let away = ((tap as f32 - center) / ratio).abs();
                if away < 1.0 { 1.0 - away } else { 0.0 }
            })
            .collect();
        let sum: f32 = weights.iter().fold(0.0, |sum, weight| sum + weight);
        weights.iter_mut().for_each(|weight| *weight /= sum);
        Taps {
            first: first as usize,
            weights,
        }
    };
    (0..to).map(of_texel).collect()
}

/// A level at half its size.
fn halved(level: &Level<'_>, [width, height]: [usize; 2], [to_width, to_height]: [usize; 2]) -> Vec<Vec4> {
    // An axis that is one texel long already stays so.
    let columns = taps(width, to_width);
    let rows = taps(height, to_height);
    let mut out = vec![Vec4::ZERO; to_width * to_height];
    let band_rows = (BAND_TEXELS / width).max(1);
    let bands = out.chunks_mut(band_rows * to_width).zip(rows.chunks(band_rows));
    tasks::for_each_on_all_threads(bands, width * height > BAND_TEXELS, |(out, rows)| {
        band(level, width, rows, &columns, out);
    });
    out
}

/// Some rows of a level at half its size.
fn band(level: &Level<'_>, width: usize, rows: &[Taps], columns: &[Taps], out: &mut [Vec4]) {
    let mut along_columns = vec![Vec4::ZERO; width];
    let mut decoded = Vec::new();
    for (taps, out) in rows.iter().zip(out.chunks_mut(columns.len())) {
        along_columns.fill(Vec4::ZERO);
        for (tap, &weight) in taps.weights.iter().enumerate() {
            let row = level.row(taps.first + tap, width, &mut decoded);
            for (sum, &value) in along_columns.iter_mut().zip(row) {
                *sum += value * weight;
            }
        }
        for (taps, out) in columns.iter().zip(out) {
            let values = &along_columns[taps.first..taps.first + taps.weights.len()];
            let mut sum = Vec4::ZERO;
            for (&value, &weight) in values.iter().zip(&taps.weights) {
                sum += value * weight;
            }
            *out = sum.clamp(Vec4::ZERO, Vec4::ONE);
        }
    }
}

#[cfg(test)]
mod tests {
    use image::imageops::FilterType;
    use image::{ImageBuffer, Rgba, Rgba32FImage};

    use super::*;
    use crate::scene::TextureWrap;

    fn texture(width: u32, height: u32) -> Texture {
        let mut state = 0x2545_f491_u32;
        let mut byte = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        Texture {
            name: "noise".to_owned(),
            width,
            height,
            rgba8: (0..width * height * 4).map(|_| byte()).collect(),
            wrap: [TextureWrap::Repeat; 2],
            linear_magnify: true,
            linear_minify: true,
        }
    }

    /// The levels by the `image` crate, on one thread.
    fn twin(texture: &Texture, srgb: bool) -> Vec<u8> {
        let encoding = Encoding::new(srgb);
        let (mut width, mut height) = (texture.width, texture.height);
        let texels = texture.rgba8.as_chunks().0;
        let mut level: Rgba32FImage = ImageBuffer::from_fn(width, height, |x, y| {
            Rgba(encoding.decode(texels[(y * width + x) as usize]).to_array())
        });
        let mut bytes = Vec::new();
        loop {
            bytes.extend(
                level
                    .pixels()
                    .flat_map(|texel| encoding.encode(Vec4::from(texel.0))),
            );
            if width == 1 && height == 1 {
                return bytes;
            }
            (width, height) = ((width / 2).max(1), (height / 2).max(1));
            level = image::imageops::resize(&level, width, height, FilterType::Triangle);
        }
    }

    #[test]
    fn levels_are_those_of_the_image_crate_bit_for_bit() {
        for (width, height) in [(1, 1), (64, 64), (37, 23), (1, 9), (10, 1), (3, 2), (300, 517)] {
            for srgb in [false, true] {
                let texture = texture(width, height);
                let chain = mip_chain(&texture, srgb, u32::MAX);
                assert!(
                    chain.rgba8 == twin(&texture, srgb),
                    "{width} × {height}, sRGB {srgb}"
                );
                assert_eq!((chain.width, chain.height), (width, height));
                assert_eq!(chain.levels, width.max(height).ilog2() + 1);
            }
        }
    }

    #[test]
    fn a_texture_beyond_the_limit_begins_at_the_first_level_that_fits() {
        let texture = texture(40, 20);
        let whole = mip_chain(&texture, true, 40);
        let limited = mip_chain(&texture, true, 16);
        assert_eq!((limited.width, limited.height, limited.levels), (10, 5, 4));
        assert_eq!(size_within([40, 20], 16), [10, 5]);
        assert_eq!(size_within([40, 20], 40), [40, 20]);
        assert!(whole.rgba8.ends_with(&limited.rgba8));
    }
}
