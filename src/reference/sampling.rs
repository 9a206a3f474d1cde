//! Repeatable stratified samples of the unit square.

/// Random numbers that depend only on a seed and a stream, so that the order of threads has no influence.
///
/// Source: Steele, Lea, Flood 2014, "Fast Splittable Pseudorandom Number Generators" (SplitMix64).
#[derive(Clone, Debug)]
pub(super) struct SplitMix(u64);

/// The odd integer nearest to 2⁶⁴ / φ.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

impl SplitMix {
    /// The random numbers of one stream (such as a pixel) for a seed.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(mix(mix(seed.wrapping_add(GOLDEN)) ^ stream.wrapping_mul(GOLDEN)))
    }

    /// The next number, uniform in 0..1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(GOLDEN);
        (mix(self.0) >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Side of the square grid of strata for about `samples` samples: √samples, rounded, at least 1.
pub(super) fn strata_per_side(samples: u32) -> u32 {
    (f64::from(samples).sqrt().round() as u32).max(1)
}

/// Yields one sample in each of `side · side` strata of the unit square, row by row.
pub(super) fn stratified(side: u32, random: SplitMix) -> Stratified {
    Stratified {
        side,
        column: 0,
        row: 0,
        random,
    }
}

/// The samples of [`stratified`]. Adapters of ranges would do the same, with calls in tests that cost more than the samples.
pub(super) struct Stratified {
    side: u32,
    column: u32,
    row: u32,
    random: SplitMix,
}

impl Iterator for Stratified {
    type Item = [f64; 2];

    fn next(&mut self) -> Option<[f64; 2]> {
        if self.column == self.side {
            (self.column, self.row) = (0, self.row + 1);
        }
        if self.row >= self.side {
            return None;
        }
        let side = f64::from(self.side);
        let u = (f64::from(self.column) + self.random.unit()) / side;
        let v = (f64::from(self.row) + self.random.unit()) / side;
        self.column += 1;
        Some([u, v])
    }
}
