//! The part of space behind a rectangle of a picture.

use glam::{DMat3, DVec3};

use super::projection::Projection;

/// Maps texels and depth to space relative to the projection's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Beams {
    right: DVec3,
    up: DVec3,
    along: DVec3,
    size: (f64, f64),
    parallel: bool,
}

/// All points that are seen through a rectangle of texels: `origin + s · direction`, for any origin and
/// direction within these bounds and a depth `s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Beam {
    origin: (DVec3, DVec3),
    direction: (DVec3, DVec3),
}

impl Beams {
    /// The beams of a projection. `None` if the projection is singular.
    pub(super) fn new(projection: &Projection) -> Option<Self> {
        let [x, y, w, key] = projection.rows().map(|row| row.truncate());
        let parallel = projection.is_parallel();
        let depth = if parallel { -key } else { w };
        let inverse = DMat3::from_cols(x, y, depth).transpose().inverse();
        let size = projection.size.as_dvec2();
        inverse.is_finite().then_some(Self {
            right: inverse.x_axis,
            up: inverse.y_axis,
            along: inverse.z_axis,
            size: (size.x, size.y),
            parallel,
        })
    }

    /// The beam through a range of columns and a range of rows, both in texels.
    pub(super) fn beam(&self, columns: (f64, f64), rows: (f64, f64)) -> Beam {
        let (width, height) = self.size;
        let (x0, x1) = (columns.0 / width * 2.0 - 1.0, columns.1 / width * 2.0 - 1.0);
        let (y0, y1) = (1.0 - rows.1 / height * 2.0, 1.0 - rows.0 / height * 2.0);
        let middle = self.right * ((x0 + x1) * 0.5) + self.up * ((y0 + y1) * 0.5);
        let spread = self.right.abs() * ((x1 - x0) * 0.5) + self.up.abs() * ((y1 - y0) * 0.5);
        let range = |at: DVec3| (at - spread, at + spread);
        if self.parallel {
            Beam {
                origin: range(middle),
                direction: (self.along, self.along),
            }
        } else {
            Beam {
                origin: (DVec3::ZERO, DVec3::ZERO),
                direction: range(middle + self.along),
            }
        }
    }
}

impl Beam {
    /// The range of depths, within `from..=to`, at which the beam may be inside a box. `None` if there is
    /// none.
    pub(super) fn depths(&self, min: DVec3, max: DVec3, from: f64, to: f64) -> Option<(f64, f64)> {
        let (mut s0, mut s1) = (from, to);
        for axis in 0..3 {
            let (low, high) = (min[axis] - self.origin.1[axis], max[axis] - self.origin.0[axis]);
            let (d0, d1) = (self.direction.0[axis], self.direction.1[axis]);
            if !self.clip(low, high, d0, d1, &mut s0, &mut s1) {
                return None;
            }
        }
        (s0 <= s1).then_some((s0, s1))
    }

    /// Narrows `s0..=s1` to where `s · d`, for some `d` in `d0..=d1`, may be within `low..=high`. Returns
    /// `false` if nothing remains.
    fn clip(&self, low: f64, high: f64, d0: f64, d1: f64, s0: &mut f64, s1: &mut f64) -> bool {
        if d0 > 0.0 {
            // The product grows with s for every direction in the range.
            *s0 = s0.max(if low > 0.0 { low / d1 } else { low / d0 });
            *s1 = s1.min(if high > 0.0 { high / d0 } else { high / d1 });
        } else if d1 < 0.0 {
            *s0 = s0.max(if high < 0.0 { high / d0 } else { high / d1 });
            *s1 = s1.min(if low < 0.0 { low / d1 } else { low / d0 });
        } else if *s0 >= 0.0 {
            if low > 0.0 {
                if d1 <= 0.0 {
                    return false;
                }
                *s0 = s0.max(low / d1);
            }
            if high < 0.0 {
                if d0 >= 0.0 {
                    return false;
                }
                *s0 = s0.max(high / d0);
            }
        } else {
            // Parallel beams have `d` = 0 across this axis.
            return low <= 0.0 && high >= 0.0;
        }
        *s0 <= *s1
    }

    /// The box around the beam between two depths, relative to the projection's origin.
    pub(super) fn bounds(&self, s0: f64, s1: f64) -> (DVec3, DVec3) {
        let (d0, d1) = self.direction;
        let low = (d0 * s0).min(d0 * s1).min(d1 * s0).min(d1 * s1);
        let high = (d0 * s0).max(d0 * s1).max(d1 * s0).max(d1 * s1);
        (self.origin.0 + low, self.origin.1 + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beam_meets_a_box_where_its_rays_do() {
        let axes = [DVec3::X, DVec3::Y, DVec3::NEG_Z];
        let projection = Projection::perspective(DVec3::ZERO, axes, 1.0, 0.01, 64);
        let beams = Beams::new(&projection).unwrap();
        let beam = beams.beam((31.5, 32.5), (31.5, 32.5));
        let (min, max) = (DVec3::new(-1.0, -1.0, -3.0), DVec3::new(1.0, 1.0, -2.0));
        let (s0, s1) = beam.depths(min, max, 0.01, 1e9).unwrap();
        assert!((s0 - 2.0).abs() < 0.1 && s0 <= 2.0 && (s1 - 3.0).abs() < 0.1 && s1 >= 3.0);
        let beside = beams.beam((63.0, 64.0), (31.5, 32.5));
        assert_eq!(beside.depths(min, max, 0.01, 1e9), None);
    }

    #[test]
    fn a_parallel_beam_does_too() {
        let bounds = crate::geometry::Aabb {
            min: glam::Vec3::splat(-4.0),
            max: glam::Vec3::splat(4.0),
        };
        let axes = [DVec3::X, DVec3::Y, DVec3::NEG_Z];
        let beams = Beams::new(&Projection::parallel(&bounds, axes, 64)).unwrap();
        let beam = beams.beam((32.0, 40.0), (24.0, 32.0));
        let (min, max) = (DVec3::new(0.0, 0.0, -3.0), DVec3::new(1.0, 1.0, -2.0));
        let (s0, s1) = beam.depths(min, max, -1e9, 1e9).unwrap();
        assert!((s0 - 2.0).abs() < 1e-9 && (s1 - 3.0).abs() < 1e-9);
        assert_eq!(
            beam.depths(min - DVec3::X * 2.0, max - DVec3::X * 2.0, -1e9, 1e9),
            None
        );
        let (low, high) = beam.bounds(s0, s1);
        assert!(low.z <= -3.0 && high.z >= -2.0 && high.x < 1.1);
    }
}
