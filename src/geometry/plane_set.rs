//! Half-spaces, and convex volumes as their intersection.

use glam::{Vec3, Vec4};
use smallvec::SmallVec;

use super::Aabb;

/// A half-space: the points with `normal · p + offset ≥ 0` are inside. `normal` has unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit vector that points inside.
    pub normal: Vec3,
    /// Signed distance of the origin, metres.
    pub offset: f32,
}

impl Plane {
    /// The half-space through `point` that `normal` points into; `None` if the normal has no direction.
    pub fn through(point: Vec3, normal: Vec3) -> Option<Self> {
        let normal = normal.try_normalize()?;
        Some(Self {
            normal,
            offset: -normal.dot(point),
        })
    }

    /// Signed distance of `point`, metres; positive inside.
    pub fn distance(&self, point: Vec3) -> f32 {
        self.normal.dot(point) + self.offset
    }

    /// Sign of a homogeneous point: a distance for `w = 1`, the slope of leaving for a direction (`w = 0`).
    pub fn side(&self, point: Vec4) -> f32 {
        self.normal.dot(point.truncate()) + self.offset * point.w
    }

    /// Largest signed distance of any point of the box.
    pub fn farthest_inside(&self, aabb: &Aabb) -> f32 {
        self.distance(aabb.center()) + self.normal.abs().dot(aabb.half_size())
    }
}

/// A convex volume: the intersection of its half-spaces. Without planes it holds everything.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlaneSet {
    /// The half-spaces, in no order.
    pub planes: SmallVec<[Plane; 16]>,
}

impl PlaneSet {
    /// Whether the box lies wholly outside of one plane. Conservative: `false` for some boxes that miss the
    /// volume near its corners, never `true` for a box that touches it.
    pub fn excludes_aabb(&self, aabb: &Aabb) -> bool {
        self.planes.iter().any(|plane| plane.farthest_inside(aabb) < 0.0)
    }

    /// Whether all homogeneous points (a convex hull's corners) lie outside of one plane.
    pub fn excludes_points(&self, points: &[Vec4]) -> bool {
        excludes_points(&self.planes, points)
    }
}

/// Whether the convex hull of homogeneous points lies wholly outside of one of the planes; conservative.
pub fn excludes_points(planes: &[Plane], points: &[Vec4]) -> bool {
    planes
        .iter()
        .any(|plane| points.iter().all(|&point| plane.side(point) < 0.0))
}
