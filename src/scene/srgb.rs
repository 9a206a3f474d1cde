//! The transfer function of sRGB, for bytes by tables.
//!
//! Source: IEC 61966-2-1.

use std::sync::LazyLock;

/// Cells of the encoding table. A cell is so narrow that at most two bytes begin in it: near 0, where the function is
/// steepest, a cell spans 0.8 of a byte.
const CELLS: usize = 4096;

static DECODED: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| decode_by_formula(byte as u8)));

static ENCODING: LazyLock<Encoding> = LazyLock::new(Encoding::new);

struct Encoding {
    /// The least number that becomes each byte, and a number that no other reaches at the end.
    least: [f32; 257],
    /// The byte of the number at which each cell begins.
    first: Vec<u8>,
}

impl Encoding {
    fn new() -> Self {
        let mut least = [0.0; 257];
        least[256] = f32::INFINITY;
        for (byte, least) in least.iter_mut().enumerate().take(256).skip(1) {
            // Positive numbers are in the order of their bits.
            let (mut low, mut high) = (0, 1.0f32.to_bits());
            while low < high {
                let middle = low + (high - low) / 2;
                if usize::from(encode_by_formula(f32::from_bits(middle))) >= byte {
                    high = middle;
                } else {
                    low = middle + 1;
                }
            }
            *least = f32::from_bits(high);
        }
        let first = (0..=CELLS).map(|cell| encode_by_formula(cell as f32 / CELLS as f32));
        Self {
            least,
            first: first.collect(),
        }
    }
}

/// The linear value of a byte, 0..=1.
#[cfg(any(feature = "gltf", test))]
pub(crate) fn decode(byte: u8) -> f32 {
    DECODED[usize::from(byte)]
}

/// The linear values of all bytes, for loops that decode many.
#[cfg(feature = "render")]
pub(crate) fn decoded() -> &'static [f32; 256] {
    &DECODED
}

/// The byte of a linear value. Values outside 0..=1 are clamped.
#[cfg(any(feature = "gltf", test))]
pub(crate) fn encode(linear: f32) -> u8 {
    Encoder::default().encode(linear)
}

/// The encoding, for loops that encode many values.
#[derive(Clone, Copy)]
pub(crate) struct Encoder(&'static Encoding);

impl Default for Encoder {
    fn default() -> Self {
        Self(&ENCODING)
    }
}

impl Encoder {
    /// The byte of a linear value. Values outside 0..=1 are clamped.
    #[inline]
    pub fn encode(self, linear: f32) -> u8 {
        let clamped = linear.clamp(0.0, 1.0); // NaN stays, and is byte 0 below
        let mut byte = usize::from(self.0.first[(clamped * CELLS as f32) as usize]);
        while clamped >= self.0.least[byte + 1] {
            byte += 1;
        }
        byte as u8
    }
}

fn decode_by_formula(byte: u8) -> f32 {
    linear_from_srgb(f32::from(byte) / 255.0)
}

/// The linear value of an encoded one, 0..=1.
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

fn encode_by_formula(linear: f32) -> u8 {
    let encoded = if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    (encoded.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_are_the_formulas() {
        for byte in 0..=255 {
            assert_eq!(decode(byte), decode_by_formula(byte));
            assert_eq!(encode(decode(byte)), byte);
            let least = ENCODING.least[usize::from(byte)].to_bits();
            for bits in least.saturating_sub(2)..=least + 2 {
                let linear = f32::from_bits(bits);
                assert_eq!(encode(linear), encode_by_formula(linear), "{linear:e}");
            }
        }
        for step in 0..100_000 {
            let linear = (step as f32 - 1000.0) / 98_000.0;
            assert_eq!(encode(linear), encode_by_formula(linear), "{linear}");
        }
        assert_eq!(
            (encode(f32::NAN), encode(f32::INFINITY), encode(f32::NEG_INFINITY)),
            (0, 255, 0)
        );
    }
}
