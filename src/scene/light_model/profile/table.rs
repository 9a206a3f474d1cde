//! Intensity by angle: what a profile's file says, with all symmetries unfolded.

use glam::{DVec3, Vec3};

/// The axes from which the angles of a table count, in the light's local space: it shines along −Z, +Y is up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    /// Direction whose polar angle is 0.
    pole: Vec3,
    /// Direction at the polar angle of 90 degrees whose azimuth is 0.
    zero: Vec3,
    /// Direction at the polar angle of 90 degrees whose azimuth is 90 degrees.
    quarter: Vec3,
}

impl Frame {
    /// Polar angles count from the aim. Photometry of type C, and EULUMDAT: the plane C0 lies along +X, the plane C90
    /// along +Y.
    pub const ABOUT_AIM: Self = Self {
        pole: Vec3::NEG_Z,
        zero: Vec3::X,
        quarter: Vec3::Y,
    };
    /// Polar angles count from the right. Photometry of type B.
    pub const ABOUT_RIGHT: Self = Self {
        pole: Vec3::X,
        zero: Vec3::NEG_Z,
        quarter: Vec3::Y,
    };
    /// Polar angles count from above. Photometry of type A.
    pub const ABOUT_UP: Self = Self {
        pole: Vec3::Y,
        zero: Vec3::NEG_Z,
        quarter: Vec3::X,
    };
}

/// Relative intensity by direction. The brightest direction of the file has 1.
///
/// Between the angles of the file the intensity is linear in both angles. Beyond them it is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileTable {
    frame: Frame,
    /// Azimuth of each plane, degrees, ascending. One plane holds for all azimuths. Planes of a whole circle span 360
    /// degrees: the last one repeats the first one.
    azimuth: Vec<f64>,
    /// Polar angle of each intensity of a plane, degrees, ascending.
    polar: Vec<f64>,
    /// Intensities, plane after plane.
    values: Vec<f32>,
    brightest: f64,
}

/// A table with equal steps along each axis, as the GPU reads it.
#[cfg(feature = "render")]
#[derive(Clone, Debug, PartialEq)]
pub struct UniformTable {
    /// Number of polar angles, which is the width of the texture.
    pub width: u32,
    /// Number of planes, which is the height of the texture.
    pub height: u32,
    /// First polar angle and first azimuth, radians.
    pub first: [f32; 2],
    /// Steps in each radian, of the polar angle and of the azimuth. The latter is 0 if there is one plane.
    pub steps: [f32; 2],
    /// Axes of the angles in the light's local space: pole, azimuth 0, azimuth 90 degrees.
    pub axes: [Vec3; 3],
    /// Relative intensities, plane after plane.
    pub values: Vec<f32>,
}

impl ProfileTable {
    /// Makes a table of intensities that are relative to the brightest direction, which has `brightest` candela.
    pub(super) fn new(
        frame: Frame,
        azimuth: Vec<f64>,
        polar: Vec<f64>,
        values: Vec<f32>,
        brightest: f64,
    ) -> Self {
        Self {
            frame,
            azimuth,
            polar,
            values,
            brightest,
        }
    }

    /// Intensity of the brightest direction in the file, candela.
    pub fn brightest(&self) -> f32 {
        self.brightest as f32
    }

    /// Returns the relative intensity in a direction, which is given in the light's local space and need not be a
    /// unit vector. The result is between 0 and 1, and 0 for the zero vector.
    pub fn relative(&self, direction_local: Vec3) -> f32 {
        let [polar, azimuth] = self.angles_of(direction_local.as_dvec3());
        self.at_angles(polar, azimuth) as f32
    }

    /// Polar angle and azimuth of a direction, degrees.
    fn angles_of(&self, direction: DVec3) -> [f64; 2] {
        let along = |axis: Vec3| direction.dot(axis.as_dvec3());
        let (zero, quarter) = (along(self.frame.zero), along(self.frame.quarter));
        let polar = zero.hypot(quarter).atan2(along(self.frame.pole));
        [polar.to_degrees(), quarter.atan2(zero).to_degrees()]
    }

    fn at_angles(&self, polar: f64, azimuth: f64) -> f64 {
        let first = self.azimuth[0];
        let turned = first + (azimuth - first).rem_euclid(360.0);
        let plane = if self.azimuth.len() == 1 {
            Some((0, 0.0))
        } else {
            interval(&self.azimuth, turned)
        };
        let (Some((plane, across)), Some((angle, along))) = (plane, interval(&self.polar, polar)) else {
            return 0.0;
        };
        let next = |at: usize, len: usize| (at + 1).min(len - 1);
        let in_plane = |plane: usize| {
            let value = |angle: usize| f64::from(self.values[plane * self.polar.len() + angle]);
            let (low, high) = (value(angle), value(next(angle, self.polar.len())));
            low + (high - low) * along
        };
        let (low, high) = (in_plane(plane), in_plane(next(plane, self.azimuth.len())));
        low + (high - low) * across
    }

    /// Resamples the table with equal steps. If the angles of the file are multiples of one step, as they nearly
    /// always are, the result says the same as the table.
    #[cfg(feature = "render")]
    pub(crate) fn uniform(&self) -> UniformTable {
        let (polar, azimuth) = (Steps::of(&self.polar), Steps::of(&self.azimuth));
        let mut values = Vec::with_capacity(polar.count * azimuth.count);
        for plane in 0..azimuth.count {
            let azimuth = azimuth.at(plane).min(self.azimuth[self.azimuth.len() - 1]);
            for angle in 0..polar.count {
                values.push(self.at_angles(polar.at(angle), azimuth) as f32);
            }
        }
        UniformTable {
            width: polar.count as u32,
            height: azimuth.count as u32,
            first: [polar.first, azimuth.first].map(|angle| angle.to_radians() as f32),
            steps: [polar.in_a_radian(), azimuth.in_a_radian()],
            axes: [self.frame.pole, self.frame.zero, self.frame.quarter],
            values,
        }
    }
}

/// Returns the interval of ascending `knots` that holds `x`, and the place of `x` in it, 0 to 1. `None` outside of the
/// knots.
fn interval(knots: &[f64], x: f64) -> Option<(usize, f64)> {
    /// Angles this near to the end of the table, in degrees, belong to it.
    const SLACK: f64 = 1e-4;
    let (first, last) = (*knots.first()?, *knots.last()?);
    if !(first - SLACK <= x && x <= last + SLACK) {
        return None;
    }
    let x = x.clamp(first, last);
    let above = knots.partition_point(|knot| *knot <= x);
    let at = above.clamp(1, (knots.len() - 1).max(1)) - 1;
    let width = knots.get(at + 1).map_or(1.0, |next| next - knots[at]);
    Some((at, (x - knots[at]) / width))
}

/// Equal steps that hold ascending angles.
#[cfg(feature = "render")]
struct Steps {
    first: f64,
    step: f64,
    count: usize,
}

#[cfg(feature = "render")]
impl Steps {
    /// The widest steps that hold every angle, or the narrowest ones that are allowed if there are none.
    fn of(angles: &[f64]) -> Self {
        /// The most angles along an axis of the texture.
        const MOST: usize = 2048;
        /// Angles are multiples of this part of a degree.
        const UNIT: f64 = 1000.0;
        let first = angles[0];
        let range = angles[angles.len() - 1] - first;
        if range == 0.0 {
            return Self {
                first,
                step: 1.0,
                count: 1,
            };
        }
        let step = angles.iter().fold(0, |step, angle| {
            gcd(step, ((angle - first) * UNIT).round() as u64)
        });
        let on_grid = |angle: &f64| {
            let units = (angle - first) * UNIT;
            (units - units.round()).abs() < 1e-3
        };
        let count = (range * UNIT / step as f64).round() as usize + 1;
        if count <= MOST && angles.iter().all(on_grid) {
            let step = range / (count - 1) as f64;
            return Self { first, step, count };
        }
        Self {
            first,
            step: range / (MOST - 1) as f64,
            count: MOST,
        }
    }

    fn at(&self, index: usize) -> f64 {
        self.first + self.step * index as f64
    }

    fn in_a_radian(&self) -> f32 {
        if self.count == 1 {
            0.0
        } else {
            self.step.to_radians().recip() as f32
        }
    }
}

#[cfg(feature = "render")]
fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}
