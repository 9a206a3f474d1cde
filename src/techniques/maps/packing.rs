//! Packings of squared distances, as shares of the squared range, into the bytes of an RGBA texel. They are
//! twins of the functions of the same names in `shaders/common/map.wgsl`.
//!
//! A byte `b` is read as `b / 255`, and bytes are unpacked as in the chapter:
//! `r + g / 256 (+ b / 65536 + a / 16777216)`. Its `r · 256 + g` is the same for distances that reach 256.
//! The packings are chosen so that unpacking returns the nearest value below.
//! Source: Gerasimov 2004, GPU Gems ch. 12, §12.3.3 and §12.3.6.

/// Largest step between two shares that [`pack_two_bytes`] distinguishes.
pub const TWO_BYTES_STEP: f32 = 1.0 / 255.0 / 256.0;

/// Largest step between two small shares that [`pack_four_bytes`] distinguishes. Larger shares are rounded as floats are.
pub const FOUR_BYTES_STEP: f32 = 1.0 / 255.0 / 16_777_216.0;

/// Rounding of a share that is packed into four bytes and unpacked, as a share of it.
#[cfg(test)]
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// Packs by the cheaper method: whole part in red, fraction in green. `share` is 0..=1.
pub fn pack_two_bytes(share: f32) -> [u8; 2] {
    let [r, g, ..] = pack_four_bytes(share);
    [r, g]
}

/// Unpacks what [`pack_two_bytes`] packed, up to [`TWO_BYTES_STEP`].
pub fn unpack_two_bytes(bytes: [u8; 2]) -> f32 {
    unpack_four_bytes([bytes[0], bytes[1], 0, 0])
}

/// Packs by the more exact method: four digits to the base 256. `share` is 0..=1.
pub fn pack_four_bytes(share: f32) -> [u8; 4] {
    let mut rest = share.clamp(0.0, 1.0) * 255.0;
    let mut bytes = [0; 4];
    for byte in &mut bytes {
        let digit = rest.floor().min(255.0);
        *byte = digit as u8;
        rest = (rest - digit) * 256.0;
    }
    bytes
}

/// Unpacks what [`pack_four_bytes`] packed.
pub fn unpack_four_bytes(bytes: [u8; 4]) -> f32 {
    let [r, g, b, a] = bytes.map(|byte| f32::from(byte) / 255.0);
    r + g / 256.0 + b / 65536.0 + a / 16_777_216.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_shares_are_within_their_steps() {
        for i in 0..=100_000u32 {
            let share = i as f32 / 100_000.0;
            let two = unpack_two_bytes(pack_two_bytes(share));
            assert!(
                two <= share + 1e-7 && share - two <= TWO_BYTES_STEP * 1.01,
                "{share} {two}"
            );
            for share in [share, share.powi(8)] {
                let four = unpack_four_bytes(pack_four_bytes(share));
                let error = (four - share).abs();
                assert!(error <= FOUR_BYTES_STEP + ROUNDING * share, "{share} {four}");
            }
        }
        assert!(
            unpack_two_bytes([1, 0]) - unpack_two_bytes([0, 0]) > TWO_BYTES_STEP,
            "the check can fail"
        );
    }
}
