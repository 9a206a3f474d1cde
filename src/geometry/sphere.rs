//! Bounding sphere.

use glam::{Affine3A, Vec3, Vec3A};

use super::Aabb;

/// A sphere. An infinite radius makes it hold everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre of the sphere, metres.
    pub center: Vec3,
    /// Radius, metres. It may be infinite and is never negative.
    pub radius: f32,
}

impl Sphere {
    /// Whether the sphere and the box share a point.
    ///
    /// Source: Arvo 1990, "A Simple Method for Box-Sphere Intersection Testing", Graphics Gems.
    pub fn intersects_aabb(&self, aabb: &Aabb) -> bool {
        aabb.distance_sq(self.center) <= self.radius * self.radius
    }

    /// Whether a box of local space lies wholly beyond a plane that separates it from the sphere. The plane
    /// is perpendicular to the line between the two centres, so the test is tighter than one of the box's
    /// world-space bounds. Conservative: `false` for some boxes that miss the sphere, never `true` for one
    /// that touches it.
    pub fn excludes_oriented(&self, local: &Aabb, world_from_local: &Affine3A) -> bool {
        let center = world_from_local.transform_point3a(Vec3A::from(local.center()));
        let towards = center - Vec3A::from(self.center);
        let distance = towards.length();
        // Without a finite line between the centres nothing can be excluded.
        if !(distance > 0.0 && distance.is_finite()) {
            return false;
        }
        let m = world_from_local.matrix3;
        let half = Vec3A::from(local.half_size());
        let normal = towards / distance;
        let along = Vec3A::new(m.x_axis.dot(normal), m.y_axis.dot(normal), m.z_axis.dot(normal));
        let reach = along.abs().dot(half);
        // The slack covers rounding of the sums and of the centres, whose coordinates may be large compared
        // with the distance.
        let size = center.abs() + Vec3A::from(self.center).abs();
        let slack = 8.0 * f32::EPSILON * (size.element_sum() + reach + self.radius);
        distance > self.radius + reach + slack
    }

    /// The box around the sphere. It is infinite for an infinite radius.
    pub fn aabb(&self) -> Aabb {
        Aabb {
            min: self.center - self.radius,
            max: self.center + self.radius,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, EulerRot, Quat};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn no_oriented_box_with_a_point_inside_is_excluded(
            numbers in prop::array::uniform12(-1.0f32..1.0),
            radius in 0.01f32..5.0,
            far in prop::sample::select(vec![0.0f32, 300.0, 1e5]),
        ) {
            let [x, y, z, a, b, c, hx, hy, hz, u, v, w] = numbers;
            let half = Vec3::new(hx, hy, hz).abs() * 3.0;
            let local = Aabb::around(Vec3::new(u, v, w), half);
            let rotation = Quat::from_euler(EulerRot::XYZ, a * 3.0, b * 3.0, c * 3.0);
            let scale = Vec3::new(1.0 + u, -1.0 + 0.5 * v, 0.1 + w * w);
            let at = Vec3::new(x, y, z) * 8.0 + far;
            let world_from_local = Affine3A::from_scale_rotation_translation(scale, rotation, at);
            let sphere = Sphere { center: Vec3::splat(far), radius };
            let excluded = sphere.excludes_oriented(&local, &world_from_local);
            let mut nearest = f64::INFINITY;
            for i in 0..=8 {
                for j in 0..=8 {
                    for k in 0..=8 {
                        let share = DVec3::new(f64::from(i), f64::from(j), f64::from(k)) / 8.0;
                        let point = local.min.as_dvec3() + (local.max - local.min).as_dvec3() * share;
                        let m = world_from_local.matrix3.as_dmat3();
                        let world = m * point + world_from_local.translation.as_dvec3();
                        nearest = nearest.min(world.distance(sphere.center.as_dvec3()));
                    }
                }
            }
            prop_assert!(!(excluded && nearest <= f64::from(radius)), "{nearest} of {radius}");
            // A box that is clearly apart is excluded: its bounding ball does not reach the sphere.
            let reach = f64::from(world_from_local.transform_vector3(local.half_size()).length())
                .max(f64::from((scale.abs() * local.half_size()).length()));
            let center = world_from_local.transform_point3(local.center());
            let apart = center.as_dvec3().distance(sphere.center.as_dvec3());
            prop_assert!(excluded || apart <= (f64::from(radius) + reach) * 1.01 + f64::from(far) * 1e-4);
        }
    }
}
