//! Axis-aligned bounding box.

use glam::{Affine3A, Vec3, Vec3A};

/// An axis-aligned box by its corners. Empty when any `min` component exceeds its `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest coordinates, metres.
    pub min: Vec3,
    /// Largest coordinates, metres.
    pub max: Vec3,
}

impl Aabb {
    /// The box that holds nothing; joining it with a point gives that point.
    pub const EMPTY: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    /// Coordinates that [`Aabb::padded`] keeps, metres.
    pub const LIMIT: f32 = 1e15;

    /// Share of each coordinate by which [`Aabb::padded`] grows a box.
    pub const PAD: f32 = 8.0 * f32::EPSILON;

    /// Share of the largest coordinate by which it grows all sides.
    pub const PAD_OF_LARGEST: f32 = 1e-10;

    /// The smallest box around `points`; points that are not finite are left out.
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points
            .into_iter()
            .filter(|point| point.is_finite())
            .fold(Self::EMPTY, Self::including)
    }

    /// The box around `center` with half sizes along each axis; empty if one of them is negative.
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

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The part in both; may be empty.
    pub fn intersection(self, other: Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        }
    }

    /// Whether no point lies inside. A box with NaN is empty.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Middle of the box.
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Half of the box's size along each axis.
    pub fn half_size(&self) -> Vec3 {
        (self.max - self.min) * 0.5
    }

    /// The eight corners; bit 0, 1, 2 of the index choose `max` on x, y, z.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            Vec3::select(
                glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0),
                self.max,
                self.min,
            )
        })
    }

    /// The box around this box after `b_from_a`. Empty stays empty; NaN in the transform gives empty.
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

    /// Whether `point` lies inside or on the border.
    pub fn contains(&self, point: Vec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// Squared distance from `point` to the nearest point of the box; 0 inside.
    pub fn distance_sq(&self, point: Vec3) -> f32 {
        point.clamp(self.min, self.max).distance_squared(point)
    }

    /// Whether the two boxes share a point.
    pub fn intersects(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// The box grown by what a plane, sphere or cone test in `f32` can lose to rounding: eight epsilons of each
    /// coordinate, and 1e-10 of the largest. Coordinates beyond ±1e15 m are brought to that, so that an infinite
    /// box stays a box that squares without overflow. Empty stays empty.
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
