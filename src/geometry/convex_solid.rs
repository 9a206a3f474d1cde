//! The parts of convex solids: half-spaces, and the edges between their planes.

use glam::{DVec3, DVec4};

use super::Plane;

/// A half-space in `f64`, relative to an origin near the solid. Inside is `normal · p + offset ≥ 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HalfSpace {
    pub(super) normal: DVec3,
    pub(super) offset: f64,
}

impl HalfSpace {
    /// Signed distance of a point (`w = 1`), or its rate of change along a direction (`w = 0`).
    pub(super) fn side(&self, point: DVec4) -> f64 {
        self.normal.dot(point.truncate()) + self.offset * point.w
    }

    /// Converts this half-space, which is relative to `origin`, to a world-space plane in `f32`. The plane is
    /// moved outward by as much as rounding can lose.
    ///
    /// A test `n·c + |n|·h + d ≥ 0` in `f32` is wrong by less than nine roundings (2⁻²⁴ each) of the sum of
    /// its terms' magnitudes: the normal's own rounding, the products, the additions. Eight epsilons (2⁻²³
    /// each) of `d` are added here, and eight of the box's coordinates by
    /// [`Aabb::padded`](super::Aabb::padded). The second term covers the construction in `f64`, whose planes
    /// are tilted by at most 1e-11 rad.
    pub(super) fn to_world(self, origin: DVec3) -> Plane {
        let offset = self.offset - self.normal.dot(origin);
        let slack = 8.0 * f64::from(f32::EPSILON) * offset.abs() + 1e-10 * origin.abs().max_element();
        Plane {
            normal: self.normal.as_vec3(),
            offset: (offset + slack) as f32,
        }
    }
}

/// An edge of a convex solid. From its first corner to its second it runs counter-clockwise around its first
/// plane, seen from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SolidEdge {
    /// Indices of the two corners that the edge connects.
    pub corners: [usize; 2],
    /// Indices of the two planes that meet at the edge.
    pub planes: [usize; 2],
}

impl SolidEdge {
    pub(super) const fn new(from: usize, to: usize, left: usize, right: usize) -> Self {
        Self {
            corners: [from, to],
            planes: [left, right],
        }
    }
}
