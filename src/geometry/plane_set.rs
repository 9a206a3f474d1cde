//! Half-spaces, and convex volumes as their intersection.

use glam::{Vec3, Vec4};
use smallvec::SmallVec;

use super::Aabb;

/// A half-space: the points with `normal · p + offset ≥ 0` are inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit vector that points inside.
    pub normal: Vec3,
    /// Signed distance of the origin from the plane, metres; positive if the origin is inside.
    pub offset: f32,
}

impl Plane {
    /// The half-space whose border passes through `point`, on the side that `normal` points to. `None` if the
    /// normal has no direction.
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

    /// Signed distance of a point (`w = 1`), or its rate of change along a direction (`w = 0`).
    pub fn side(&self, point: Vec4) -> f32 {
        self.normal.dot(point.truncate()) + self.offset * point.w
    }

    /// Largest signed distance of any point of the box, metres.
    pub fn farthest_inside(&self, aabb: &Aabb) -> f32 {
        self.distance(aabb.center()) + self.normal.abs().dot(aabb.half_size())
    }
}

/// A convex volume: the intersection of its half-spaces. Without planes it holds everything.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlaneSet {
    /// The half-spaces, in no particular order.
    pub planes: SmallVec<[Plane; 16]>,
}

impl PlaneSet {
    /// Whether the box lies wholly outside one plane. Conservative: `false` for some boxes that miss the
    /// volume near its corners, never `true` for a box that touches it.
    pub fn excludes_aabb(&self, aabb: &Aabb) -> bool {
        self.planes.iter().any(|plane| plane.farthest_inside(aabb) < 0.0)
    }

    /// Whether the convex hull of homogeneous points lies wholly outside one plane. Conservative: `false` for
    /// some hulls that miss the volume, never `true` for one that touches it.
    pub fn excludes_points(&self, points: &[Vec4]) -> bool {
        excludes_points(&self.planes, points)
    }
}

/// Whether the convex hull of homogeneous points lies wholly outside one of the planes. Conservative: `false`
/// for some hulls that miss the volume, never `true` for one that touches it.
pub fn excludes_points(planes: &[Plane], points: &[Vec4]) -> bool {
    planes
        .iter()
        .any(|plane| points.iter().all(|&point| plane.side(point) < 0.0))
}
