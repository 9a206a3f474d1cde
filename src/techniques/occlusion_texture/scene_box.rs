//! Where an object stands, as the slices of a light are fitted to it.

use glam::{Affine3A, DVec3};

use crate::geometry::Aabb;

/// A box along an object's own axes, in world space. A turned object fills it better than its world bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnBox {
    /// Centre, metres.
    pub center: DVec3,
    /// Vectors from the centre to the middles of three sides, metres. A flat object has a zero vector.
    pub halves: [DVec3; 3],
}

impl OwnBox {
    /// Places the local bounds of an object. `None` if they are empty or the box is not finite.
    pub fn new(local: &Aabb, world_from_local: &Affine3A) -> Option<Self> {
        if local.is_empty() {
            return None;
        }
        let half = (local.max.as_dvec3() - local.min.as_dvec3()) * 0.5;
        let middle = (local.max.as_dvec3() + local.min.as_dvec3()) * 0.5;
        let matrix = world_from_local.matrix3;
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.as_dvec3());
        let center = world_from_local.translation.as_dvec3() + x * middle.x + y * middle.y + z * middle.z;
        let halves = [x * half.x, y * half.y, z * half.z];
        let is_finite = center.is_finite() && halves.iter().all(|half| half.is_finite());
        is_finite.then_some(Self { center, halves })
    }

    /// Returns the least and greatest distance of the box from a point, along a unit vector.
    fn range(&self, axis: DVec3, from: DVec3) -> [f64; 2] {
        let middle = axis.dot(self.center - from);
        let half: f64 = self.halves.iter().map(|half| axis.dot(*half).abs()).sum();
        [middle - half, middle + half]
    }
}

/// The part of an object that a light reaches.
#[derive(Clone, Copy, Debug)]
pub struct SceneBox {
    /// World bounds, cut by those of the light's volume.
    pub bounds: Aabb,
    /// Box along the object's own axes, which is not cut.
    pub own: Option<OwnBox>,
    /// Whether the object casts, and slices are fitted to it.
    pub casts: bool,
}

impl SceneBox {
    /// Makes a box that is known by its world bounds alone.
    pub fn of_bounds(bounds: Aabb, casts: bool) -> Self {
        Self {
            bounds,
            own: None,
            casts,
        }
    }

    /// Returns the least and greatest distance of the object from a point along a unit vector: the part that the world
    /// bounds and the object's own box have in common.
    pub fn range(&self, axis: DVec3, from: DVec3) -> [f64; 2] {
        let center = 0.5 * (self.bounds.min.as_dvec3() + self.bounds.max.as_dvec3()) - from;
        let half = 0.5 * (self.bounds.max.as_dvec3() - self.bounds.min.as_dvec3());
        let (middle, half) = (axis.dot(center), axis.abs().dot(half));
        let world = [middle - half, middle + half];
        let Some(own) = self.own.map(|own| own.range(axis, from)) else {
            return world;
        };
        let both = [world[0].max(own[0]), world[1].min(own[1])];
        // Rounding may part the two where both are flat.
        if both[0] <= both[1] { both } else { world }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};

    /// A turned object is as wide as its own box along its own axes, and as its world bounds along those of the world.
    #[test]
    fn ranges_are_those_of_the_tighter_box() {
        let local = Aabb::around(Vec3::new(0.5, 0.0, 0.0), Vec3::new(2.0, 0.1, 1.0));
        let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.4, 0.9, -0.3);
        let placed = Affine3A::from_rotation_translation(turn, Vec3::new(1.0, 2.0, 3.0));
        let loose = SceneBox::of_bounds(local.transformed(&placed), true);
        let own = OwnBox::new(&local, &placed);
        let tight = SceneBox { own, ..loose };
        let width = |scene: &SceneBox, axis: Vec3| {
            let [least, greatest] = scene.range(axis.as_dvec3(), DVec3::ONE);
            greatest - least
        };
        for (axis, half) in [(Vec3::X, 2.0), (Vec3::Y, 0.1), (Vec3::Z, 1.0)] {
            let along = turn * axis;
            assert!((width(&tight, along) - 2.0 * half).abs() < 1e-5, "{axis}");
            assert!(width(&loose, along) > 2.2 * half, "{axis}");
            assert!((width(&tight, axis) - width(&loose, axis)).abs() < 1e-5, "{axis}");
        }
        // The part of a ground that the light reaches is less than its own box.
        let cut = SceneBox {
            bounds: tight
                .bounds
                .intersection(Aabb::around(placed.translation.into(), Vec3::splat(0.2))),
            ..tight
        };
        assert!(width(&cut, turn * Vec3::X) < 1.0);
        assert_eq!(OwnBox::new(&Aabb::EMPTY, &placed), None);
    }
}
