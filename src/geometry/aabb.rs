//! Axis-aligned bounding box.

use glam::{Affine3A, DVec3, Vec3, Vec3A};

/// An axis-aligned box, given by its two extreme corners. It is empty when any `min` component exceeds its
/// `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Corner with the smallest coordinates, metres.
    pub min: Vec3,
    /// Corner with the largest coordinates, metres.
    pub max: Vec3,
}

impl Aabb {
    /// The box that holds nothing. Its union with a point is the box of that point.
    pub const EMPTY: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    /// Largest magnitude of a coordinate that [`Aabb::padded`] keeps, metres.
    pub const LIMIT: f32 = 1e15;

    /// Share of each coordinate by which [`Aabb::padded`] grows a box.
    pub const PAD: f32 = 8.0 * f32::EPSILON;

    /// Share of the box's largest coordinate by which [`Aabb::padded`] grows every side.
    pub const PAD_OF_LARGEST: f32 = 1e-10;

    /// The smallest box around `points`. Points that are not finite are left out.
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points
            .into_iter()
            .filter(|point| point.is_finite())
            .fold(Self::EMPTY, Self::including)
    }

    /// The box around `center` with the given half sizes along each axis. It is empty if a half size is
    /// negative.
    pub fn around(center: Vec3, half_size: Vec3) -> Self {
        Self {
            min: center - half_size,
            max: center + half_size,
        }
    }

    /// This box grown to hold `point`.
    pub fn including(self, point: Vec3) -> Self {
        Self {
            min: self.min.min(point),
            max: self.max.max(point),
        }
    }

    /// The smallest box around both boxes.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The part that lies in both boxes. It may be empty.
    pub fn intersection(self, other: Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        }
    }

    /// Whether no point lies inside the box. A box with NaN is empty.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Centre of the box.
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Half of the box's size along each axis.
    pub fn half_size(&self) -> Vec3 {
        (self.max - self.min) * 0.5
    }

    /// The eight corners. Bits 0, 1 and 2 of the index choose `max` on x, y and z.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            Vec3::select(
                glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0),
                self.max,
                self.min,
            )
        })
    }

    /// The axis-aligned box around this box after `b_from_a`. An empty box stays empty; NaN in the transform
    /// gives an empty box.
    ///
    /// Source: Arvo 1990, "Transforming Axis-Aligned Bounding Boxes", Graphics Gems.
    pub fn transformed(&self, b_from_a: &Affine3A) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        let center = b_from_a.transform_point3a(Vec3A::from(self.center()));
        let half = Vec3A::from(self.half_size());
        let m = b_from_a.matrix3;
        let extent = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
        Self {
            min: (center - extent).into(),
            max: (center + extent).into(),
        }
    }

    /// Whether `point` lies inside the box or on its border.
    pub fn contains(&self, point: Vec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// Squared distance from `point` to the nearest point of the box; 0 for a point inside.
    pub fn distance_sq(&self, point: Vec3) -> f32 {
        point.clamp(self.min, self.max).distance_squared(point)
    }

    /// Whether the two boxes share a point.
    pub fn intersects(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Returns where a line enters and leaves the box, as factors on `direction`; negative before `begin`. `None` if it
    /// misses the box.
    pub fn crossed_by(&self, begin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let one = (f64::from(self.min[axis]) - begin[axis]) / direction[axis];
            let other = (f64::from(self.max[axis]) - begin[axis]) / direction[axis];
            if one.is_nan() || other.is_nan() {
                continue; // the line lies in the plane of a side, which bounds nothing
            }
            enter = enter.max(one.min(other));
            leave = leave.min(one.max(other));
        }
        (enter <= leave).then_some((enter, leave))
    }

    /// The box grown by as much as a plane, sphere or cone test in `f32` can lose to rounding: by eight
    /// epsilons of each coordinate, and by 1e-10 of the largest one. Coordinates beyond ±1e15 m are clamped
    /// to that, so that an infinite box stays a box whose squares do not overflow. An empty box stays empty.
    pub fn padded(&self) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        let limit = Vec3::splat(Self::LIMIT);
        let (min, max) = (self.min.clamp(-limit, limit), self.max.clamp(-limit, limit));
        let size = min.abs().max(max.abs());
        let pad = size * Self::PAD + Vec3::splat(size.max_element() * Self::PAD_OF_LARGEST);
        Self {
            min: min - pad,
            max: max + pad,
        }
    }
}
