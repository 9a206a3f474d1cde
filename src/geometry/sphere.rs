//! Bounding sphere.

use glam::{Affine3A, Vec3, Vec3A};

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

    /// Whether a box of local space lies wholly beyond a plane that is perpendicular to the line between both centres: tighter
    /// than the box of the box in world space. Conservative: `false` for some boxes that miss the sphere, never `true`
    /// for one that touches it.
    pub fn excludes_oriented(&self, local: &Aabb, world_from_local: &Affine3A) -> bool {
        let center = world_from_local.transform_point3a(Vec3A::from(local.center()));
        let towards = center - Vec3A::from(self.center);
        let distance = towards.length();
        // Unless there is a line, and finite, nothing is excluded.
        if !(distance > 0.0 && distance.is_finite()) {
            return false;
        }
        let m = world_from_local.matrix3;
        let half = Vec3A::from(local.half_size());
        let normal = towards / distance;
        let along = Vec3A::new(m.x_axis.dot(normal), m.y_axis.dot(normal), m.z_axis.dot(normal));
        let reach = along.abs().dot(half);
        // Rounding of the centres, whose coordinates may be large beside the distance, and of the sums.
        let size = center.abs() + Vec3A::from(self.center).abs();
        let slack = 8.0 * f32::EPSILON * (size.element_sum() + reach + self.radius);
        distance > self.radius + reach + slack
    }

    /// The box around the sphere; infinite for an infinite radius.
    pub fn aabb(&self) -> Aabb {
        Aabb {
            min: self.center - self.radius,
            max: self.center + self.radius,
        }
    }
}
