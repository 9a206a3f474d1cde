//! Casters that are a shell around everything lit, such as a sky dome or the walls of a room. They shadow nothing.

use glam::{Affine3A, DVec3};

use crate::geometry::{Aabb, Emitter};
use crate::silhouettes::CasterMesh;

/// Whether a mesh is the surface of a convex body that holds a light at a position and everything else that is lit. Then no ray
/// from the light meets it before another point of it. `rounding` is how far both may be outside, metres.
pub(super) fn is_shell_around(
    mesh: &CasterMesh,
    world_from_local: &Affine3A,
    lit: &Aabb,
    emitter: &Emitter,
    rounding: f64,
) -> bool {
    let Some(middle) = mesh.middle_of_shell.filter(|_| emitter.point.w != 0.0) else {
        return false;
    };
    let local_from_world = world_from_local.matrix3.as_dmat3().inverse();
    let origin = world_from_local.translation.as_dvec3();
    let center = 0.5 * (lit.min.as_dvec3() + lit.max.as_dvec3());
    let half = 0.5 * (lit.max.as_dvec3() - lit.min.as_dvec3());
    let holds = |slot: usize| {
        let plane = mesh.planes.plane(slot).as_dvec4();
        let normal = plane.truncate();
        if normal == DVec3::ZERO {
            return true;
        }
        let inward = (normal.dot(middle.as_dvec3()) + plane.w).signum();
        let across = inward * (local_from_world.transpose() * normal);
        let length = across.length();
        let across = across / length;
        let height = |point: DVec3| across.dot(point - origin) + inward * plane.w / length;
        let light = height(emitter.point.truncate()) - emitter.extent(across);
        light >= -rounding && (lit.is_empty() || height(center) - across.abs().dot(half) >= -rounding)
    };
    mesh.planes.slots().all(holds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::MeshData;
    use glam::{Quat, Vec3};

    fn lamp(at: DVec3, radius: f64) -> Emitter {
        Emitter {
            radius,
            ..Emitter::point(at.extend(1.0))
        }
    }

    #[test]
    fn domes_and_rooms_are_shells_around_what_they_hold() {
        let dome = CasterMesh::build(&MeshData::icosphere(100.0, 2)).expect("it has edges");
        let placed = Affine3A::from_scale_rotation_translation(
            Vec3::new(-2.0, 1.0, 3.0),
            Quat::from_rotation_y(0.7),
            Vec3::new(50.0, 0.0, 0.0),
        );
        let lit = Aabb::around(Vec3::new(50.0, 0.0, 0.0), Vec3::splat(30.0));
        let inside = |lit: &Aabb, light: &Emitter| is_shell_around(&dome, &placed, lit, light, 1e-4);
        let light = lamp(DVec3::new(50.0, 4.0, 0.0), 0.3);
        assert!(inside(&lit, &light) && inside(&Aabb::EMPTY, &light));
        assert!(!inside(
            &Aabb::around(Vec3::X * 50.0, Vec3::new(0.0, 101.0, 0.0)),
            &light
        ));
        assert!(
            !inside(&lit, &lamp(DVec3::new(50.0, 95.0, 0.0), 8.0)),
            "a part of the light"
        );
        assert!(!inside(&lit, &Emitter::point(DVec3::Y.extend(0.0))), "a sun");
        let room = CasterMesh::build(&MeshData::cuboid(Vec3::new(3.0, 1.0, 3.0))).expect("it has edges");
        let standing = Aabb::around(Vec3::new(0.0, -0.5, 0.0), Vec3::new(1.0, 0.5, 1.0));
        let place = Affine3A::IDENTITY;
        assert!(is_shell_around(
            &room,
            &place,
            &standing,
            &lamp(DVec3::ZERO, 0.1),
            1e-5
        ));
        let below = Aabb::around(Vec3::new(0.0, -0.6, 0.0), Vec3::new(1.0, 0.5, 1.0));
        assert!(!is_shell_around(
            &room,
            &place,
            &below,
            &lamp(DVec3::ZERO, 0.1),
            1e-5
        ));
        let plate = CasterMesh::build(&MeshData::plane(3.0)).expect("it has edges");
        assert!(!is_shell_around(
            &plate,
            &place,
            &Aabb::EMPTY,
            &lamp(DVec3::Y, 0.1),
            1e-5
        ));
    }
}
