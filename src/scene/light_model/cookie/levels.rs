//! Mip levels, each the average of the one before.

use glam::Vec3;

/// One mip level of a picture: linear RGB, in rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Width, texels.
    pub width: u32,
    /// Height, texels.
    pub height: u32,
    /// The texels, in rows from the top.
    pub texels: Vec<Vec3>,
}

#[cfg(any(test, feature = "render"))]
impl Level {
    /// Returns the next level, with half the size, rounded down but at least 1. A texel is the average over the area
    /// that it covers, so odd sizes lose nothing. `None` for a level of one texel.
    pub fn halved(&self) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let columns: Vec<_> = (0..width).map(|x| Cover::of(x, self.width, width)).collect();
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            let rows = Cover::of(y, self.height, height);
            for columns in &columns {
                let mut sum = Vec3::ZERO;
                for (row, tall) in rows.texels() {
                    for (column, wide) in columns.texels() {
                        sum += self.texels[row * self.width as usize + column] * (tall * wide);
                    }
                }
                texels.push(sum);
            }
        }
        Some(Self {
            width,
            height,
            texels,
        })
    }
}

/// The up to three texels of the finer level that a texel covers along one axis, and their shares.
#[cfg(any(test, feature = "render"))]
struct Cover {
    first: usize,
    shares: [f32; 3],
}

#[cfg(any(test, feature = "render"))]
impl Cover {
    /// Texel `at` of `coarse` texels, over `fine` texels.
    fn of(at: u32, fine: u32, coarse: u32) -> Self {
        let scale = f64::from(fine) / f64::from(coarse);
        let (from, to) = (f64::from(at) * scale, f64::from(at + 1) * scale);
        let first = from.floor();
        let shares = [0.0, 1.0, 2.0].map(|offset| {
            let (low, high) = (first + offset, first + offset + 1.0);
            ((to.min(high) - from.max(low)).max(0.0) / scale) as f32
        });
        Self {
            first: first as usize,
            shares,
        }
    }

    fn texels(&self) -> impl Iterator<Item = (usize, f32)> {
        let covered = self.shares.into_iter().enumerate();
        covered
            .filter(|(_, share)| *share > 0.0)
            .map(|(offset, share)| (self.first + offset, share))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_has_the_average_of_the_picture() {
        for (width, height) in [(1, 1), (2, 2), (5, 3), (7, 1), (1, 9), (16, 6)] {
            let texels: Vec<_> = (0..width * height)
                .map(|i| Vec3::splat((i * i % 11) as f32))
                .collect();
            let average: Vec3 = texels.iter().sum::<Vec3>() / (width * height) as f32;
            let mut level = Level {
                width,
                height,
                texels,
            };
            let mut count = 1;
            while let Some(next) = level.halved() {
                level = next;
                count += 1;
            }
            assert_eq!((level.width, level.height), (1, 1));
            assert_eq!(count, width.max(height).ilog2() + 1);
            assert!((level.texels[0] - average).abs().max_element() < 1e-4);
        }
    }
}
