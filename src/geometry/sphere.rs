//! Bounding sphere.

use glam::Vec3;

use super::Aabb;

/// A sphere; `radius` may be infinite (it then holds everything) and is never negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, metres.
    pub center: Vec3,
    /// Radius, metres.
    pub radius: f32,
}

impl Sphere {
    /// Whether the sphere and the box share a point.
    ///
    /// Source: Arvo 1990, "A Simple Method for Box-Sphere Intersection Testing", Graphics Gems.
    pub fn intersects_aabb(&self, aabb: &Aabb) -> bool {
        aabb.distance_sq(self.center) <= self.radius * self.radius
    }

    /// The box around the sphere; infinite for an infinite radius.
    pub fn aabb(&self) -> Aabb {
        Aabb {
            min: self.center - self.radius,
            max: self.center + self.radius,
        }
    }
}
