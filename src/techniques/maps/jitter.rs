//! Jittered samples of a disc, for each pixel of a tile.
//!
//! The samples are an 8×8 grid over radius and angle, each at random within its cell, mapped to the disc so
//! that equal cells have equal areas. The outermost ring comes first: its eight samples indicate whether the
//! disc is all lit or all dark. The set of each pixel is turned by a random angle, so that the gaps between
//! samples differ from pixel to pixel.
//! Source: Uralsky & Ahmad 2004, "Soft Shadows" (NVIDIA SDK white paper TB-01409).

/// Number of pixels along a side of the tile.
pub const TILE: u32 = 16;

/// Number of samples of a pixel.
pub const SAMPLES: u32 = 64;

/// Number of samples of the outermost ring.
pub const RIM: u32 = 8;

/// Depth of the 3D texture. Each texel holds two samples.
pub const DEPTH: u32 = SAMPLES / 2;

/// Returns a pseudo-random number in 0..1 for a counter. Source: Steele et al. 2014, "Fast Splittable
/// Pseudorandom Number Generators" (the mixing function).
fn random(counter: u64) -> f64 {
    let mut z = counter
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Returns the samples of one pixel of the tile, in the unit disc, outermost ring first.
pub fn disc(x: u32, y: u32) -> [[f32; 2]; SAMPLES as usize] {
    let set = u64::from(y * TILE + x) * (2 * u64::from(SAMPLES) + 1);
    let turn = random(set);
    std::array::from_fn(|sample| {
        let (ring, sector) = (sample as u64 / 8, sample as u64 % 8);
        let at = set + 1 + 2 * sample as u64;
        let area = 1.0 - (ring as f64 + random(at)) / 8.0;
        let angle = ((sector as f64 + random(at + 1)) / 8.0 + turn) * std::f64::consts::TAU;
        let (sin, cos) = angle.sin_cos();
        [(area.sqrt() * cos) as f32, (area.sqrt() * sin) as f32]
    })
}

/// Returns the texels of the 3D texture as signed bytes: the tile, [`DEPTH`] texels deep. Red and green hold
/// one offset, blue and alpha the next.
pub fn texels() -> Vec<u8> {
    let mut bytes = vec![0; (TILE * TILE * DEPTH * 4) as usize];
    for y in 0..TILE {
        for x in 0..TILE {
            for (sample, offset) in disc(x, y).into_iter().enumerate() {
                let layer = sample as u32 / 2;
                let at = ((layer * TILE + y) * TILE + x) as usize * 4 + sample % 2 * 2;
                for (byte, value) in bytes[at..at + 2].iter_mut().zip(offset) {
                    *byte = ((value * 127.0).round() as i8).cast_unsigned();
                }
            }
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_fill_the_disc_evenly_and_begin_at_the_rim() {
        let (mut inner, mut count) = (0, 0);
        for pixel in 0..TILE * TILE {
            let samples = disc(pixel % TILE, pixel / TILE);
            for (index, [x, y]) in samples.into_iter().enumerate() {
                let radius_sq = x * x + y * y;
                assert!(radius_sq <= 1.0);
                assert_eq!(index < RIM as usize, radius_sq >= 0.875 - 1e-6, "ring of {index}");
                inner += usize::from(radius_sq < 0.5);
                count += 1;
            }
        }
        let share = inner as f64 / count as f64;
        assert!(
            (share - 0.5).abs() < 0.01,
            "half of the area holds {share} of the samples"
        );
        assert_ne!(disc(0, 0), disc(1, 0), "each pixel has its own");
        assert_eq!(texels().len(), 16 * 16 * 32 * 4);
    }
}
