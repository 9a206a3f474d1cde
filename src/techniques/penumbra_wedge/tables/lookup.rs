//! Tables of angles and of sectors, for
//! [`CoverageMaths::Tables`](crate::techniques::penumbra_wedge::CoverageMaths::Tables).
//!
//! Source: Assarsson et al. 2003, section 4.2: a cube map of `atan2` and a texture of areas by two angles. Of
//! the cube map, only a quarter turn is needed here. Both are a buffer: 128 by 128 texels a face and 256 by
//! 256 areas would not be more exact.

/// Number of steps of a quarter turn in the table of angles.
pub const ANGLE_STEPS: usize = 1024;

/// Number of steps of a whole turn along each side of the table of sectors.
pub const SECTOR_STEPS: usize = 256;

/// Number of entries of both tables: angles, then sectors.
pub const LOOKUP_LENGTH: usize = ANGLE_STEPS + 1 + (SECTOR_STEPS + 1) * (SECTOR_STEPS + 1);

/// Returns the entries; each has its value in x.
///
/// Angle `i` is that of the direction (1 − t, t) with `t = i / ANGLE_STEPS`, in turns. Sector `(i, j)` is the
/// share of the square that the shorter way from angle `i` to angle `j` spans, both in 1/[`SECTOR_STEPS`]
/// turns.
pub fn entries() -> Vec<[f32; 4]> {
    use std::f64::consts::TAU;
    let mut all = Vec::with_capacity(LOOKUP_LENGTH);
    let mut push = |value: f64| all.push([value as f32, 0.0, 0.0, 0.0]);
    for i in 0..=ANGLE_STEPS {
        let t = i as f64 / ANGLE_STEPS as f64;
        push(t.atan2(1.0 - t) / TAU);
    }
    // Length of the way along the border of the square, which is 8 long. It grows in proportion to the area.
    let border = |step: usize| {
        let (sin, cos) = (step as f64 / SECTOR_STEPS as f64 * TAU).sin_cos();
        if cos.abs() >= sin.abs() {
            if cos > 0.0 {
                (sin / cos).rem_euclid(8.0)
            } else {
                4.0 + sin / cos
            }
        } else if sin > 0.0 {
            2.0 - cos / sin
        } else {
            6.0 - cos / sin
        }
    };
    for i in 0..=SECTOR_STEPS {
        for j in 0..=SECTOR_STEPS {
            let between = (border(i % SECTOR_STEPS) - border(j % SECTOR_STEPS)).abs();
            push(between.min(8.0 - between) / 8.0);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_angles_and_sectors() {
        let all = entries();
        assert_eq!(all.len(), LOOKUP_LENGTH);
        assert!((all[ANGLE_STEPS / 2][0] - 0.125).abs() < 1e-7);
        let sector = |i: usize, j: usize| all[ANGLE_STEPS + 1 + i * (SECTOR_STEPS + 1) + j][0];
        assert!((sector(0, SECTOR_STEPS / 4) - 0.25).abs() < 1e-6);
        assert!((sector(SECTOR_STEPS / 8, 5 * SECTOR_STEPS / 8) - 0.5).abs() < 1e-6);
        assert!((sector(7 * SECTOR_STEPS / 8, SECTOR_STEPS / 8) - 0.25).abs() < 1e-6);
    }
}
