//! Rays against triangles: no cracks, no self-shadowing, and the tree finds what brute force finds.

use antumbra::reference::{LightShape, Ray, RayScene};
use antumbra::scene::MeshData;
use bevy_transform::prelude::Transform;
use glam::{DQuat, DVec3, Quat, Vec3};
use proptest::prelude::*;

use super::harness::*;

fn vector(size: f64) -> impl Strategy<Value = DVec3> {
    [-size..size, -size..size, -size..size].prop_map(DVec3::from_array)
}

fn soup() -> impl Strategy<Value = Vec<[DVec3; 3]>> {
    let triangle = (vector(5.0), vector(2.0), vector(2.0)).prop_map(|(a, u, v)| [a, a + u, a + v]);
    // On a coarse grid many triangles share planes, corners and whole edges, and some are degenerate.
    let on_grid = [vector(3.0), vector(3.0), vector(3.0)].prop_map(|corners| corners.map(DVec3::round));
    prop::collection::vec(prop_oneof![triangle, on_grid], 0..60)
}

/// The nearest crossing by Cramer's rule, one triangle after the other; NaN where a crossing is too near to an
/// edge for this simpler test to be sure.
fn brute_force(triangles: &[[DVec3; 3]], ray: &Ray) -> f64 {
    let mut nearest = f64::INFINITY;
    let mut unsure = f64::INFINITY;
    for [a, b, c] in triangles {
        let (u, v) = (*b - *a, *c - *a);
        let determinant = ray.direction.cross(v).dot(u);
        if determinant.abs() < 1e-9 {
            if determinant != 0.0 {
                unsure = 0.0;
            }
            continue;
        }
        let p = ray.origin - *a;
        let weights = [
            ray.direction.cross(v).dot(p) / determinant,
            p.cross(u).dot(ray.direction) / determinant,
        ];
        let least = weights[0].min(weights[1]).min(1.0 - weights[0] - weights[1]);
        let t = p.cross(u).dot(v) / determinant;
        if least.abs() < 1e-9 || t.abs() < 1e-9 {
            unsure = unsure.min(t.max(0.0));
        } else if least > 0.0 && t > 0.0 {
            nearest = nearest.min(t);
        }
    }
    if unsure <= nearest { f64::NAN } else { nearest }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_tree_finds_what_brute_force_finds(triangles in soup(), origin in vector(8.0), direction in vector(1.0)) {
        let scene = RayScene::from_triangles(triangles.iter().copied());
        prop_assert_eq!(scene.triangles().len(), triangles.len());
        let ray = Ray { origin, direction };
        let expected = brute_force(&triangles, &ray);
        let hit = scene.closest_hit(&ray, 0.0, f64::INFINITY, |_| true);
        let got = hit.map_or(f64::INFINITY, |hit| hit.t);
        if !expected.is_nan() {
            let same = got == expected || (got - expected).abs() < 1e-7 * expected.max(1.0);
            prop_assert!(same, "{got}, brute force {expected}");
            let blocked = scene.blocks_direction(origin, direction, None, u32::MAX);
            prop_assert_eq!(blocked, expected.is_finite());
        }
        if let Some(hit) = hit {
            let [a, b, c] = scene.triangles()[hit.triangle as usize].corners;
            let on_triangle = a * hit.barycentric.x + b * hit.barycentric.y + c * hit.barycentric.z;
            prop_assert!(on_triangle.distance(origin + direction * hit.t) < 1e-6 * (1.0 + hit.t));
        }
    }

    #[test]
    fn no_ray_leaves_a_sphere(turn in vector(3.0), shift in vector(1e3), direction in vector(1.0), inside in vector(0.5)) {
        let sphere = MeshData::icosphere(1.0, 2);
        let rotation = DQuat::from_scaled_axis(turn);
        let corners: Vec<DVec3> =
            sphere.positions.iter().map(|p| rotation * p.as_dvec3() + shift).collect();
        let scene = RayScene::from_triangles(
            sphere.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|i| corners[i as usize])),
        );
        let origin = inside + shift;
        let middles = sphere.indices.chunks_exact(3).flat_map(|t| {
            let [a, b, c] = [t[0], t[1], t[2]].map(|i| corners[i as usize]);
            [a, (a + b) * 0.5, a.lerp(b, 0.3), (a + b + c) / 3.0]
        });
        // Aimed at corners and edges, where a test that is not watertight leaks, and anywhere.
        for target in middles.chain([origin + direction]) {
            let direction = target - origin;
            prop_assert!(
                scene.blocks_direction(origin, direction, None, u32::MAX),
                "leak towards {target}"
            );
        }
    }

    #[test]
    fn coincident_and_coplanar_faces_do_not_shadow_each_other(turn in vector(3.0), shift in vector(100.0), aim in vector(1.0)) {
        let rotation = DQuat::from_scaled_axis(turn);
        let place = |p: DVec3| rotation * p + shift;
        let [a, b, c, d] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| DVec3::new(x, 0.0, z));
        let triangles = [[a, b, c], [a, b, c], [c, b, a], [b, c, a], [a, b, d], [d, b, c], [a * 3.0, c * 2.0, b * 5.0]];
        let scene = RayScene::from_triangles(triangles.map(|triangle| triangle.map(place)));
        let normal = rotation * DVec3::Y;
        let weights = aim.abs() / aim.abs().element_sum();
        for (index, triangle) in scene.triangles().iter().enumerate() {
            let [a, b, c] = triangle.corners;
            let point = a * weights.x + b * weights.y + c * weights.z;
            let surface = Some(index as u32);
            for grazing in [1.0, 1e-3, 1e-6] {
                for side in [1.0, -1.0] {
                    let along = rotation * DVec3::new(aim.x, 0.0, aim.z);
                    let towards = along + normal * (side * grazing);
                    prop_assert!(!scene.blocks_direction(point, towards, surface, u32::MAX));
                    prop_assert!(!scene.blocks_segment(point, point + towards * 9.0, None, u32::MAX));
                }
            }
            // Control: the same point a micrometre below is shadowed by all of them.
            let below = point - normal * 1e-6;
            prop_assert!(scene.blocks_direction(below, normal, None, u32::MAX));
        }
    }
}

#[test]
fn double_faces_in_a_picture_are_lit_and_a_sheet_above_them_is_not_ignored() {
    let turned = Transform::from_rotation(Quat::from_euler(glam::EulerRot::XYZ, 0.2, 0.5, 0.1));
    let mut reversed = MeshData::plane(4.0);
    reversed.indices.reverse();
    let mut world = bevy_ecs::world::World::new();
    spawn(&mut world, MeshData::plane(4.0), turned);
    spawn(&mut world, reversed.clone(), turned);
    spawn(&mut world, MeshData::plane(2.5), turned);
    let scene = RayScene::from_world(&mut world);
    let hits = view(&scene, Vec3::new(0.0, 5.0, 4.0), Vec3::ZERO);
    let lamp = point_light(Vec3::new(2.0, 3.0, 1.0));
    assert_all(&hard(&scene, &hits, &lamp), 1.0);

    // Control: an unseen sheet a tenth of a millimetre above the others shadows everything.
    let above = Transform::from_translation(turned.rotation * Vec3::Y * 1e-4).with_rotation(turned.rotation);
    let sheet = spawn(&mut world, MeshData::plane(40.0), above);
    world
        .entity_mut(sheet)
        .remove::<antumbra::scene::SceneMaterials>();
    let scene = RayScene::from_world(&mut world);
    let hits = view(&scene, Vec3::new(0.0, 5.0, 4.0), Vec3::ZERO);
    assert_all(&hard(&scene, &hits, &lamp), 0.0);
}

#[test]
fn a_triangle_at_the_light_does_not_block_it_and_one_before_it_does() {
    let floor = [DVec3::ZERO, DVec3::Z, DVec3::X];
    let at = |height: f64| {
        [
            DVec3::new(-2.0, height, -2.0),
            DVec3::new(0.0, height, 5.0),
            DVec3::new(5.0, height, 0.0),
        ]
    };
    let point = DVec3::new(0.2, 0.0, 0.2);
    for (height, blocked) in [
        (2.0, false),
        (2.0 - 1e-8, false), // nearer to the light than its clearance
        (2.0 - 1e-5, false),
        (2.0 - 1e-3, true),
        (1.0, true),
        (1e-6, true),
        (2.1, false),
    ] {
        let scene = RayScene::from_triangles([floor, at(height)]);
        let got = scene.blocks_segment(point, point + DVec3::Y * 2.0, None, u32::MAX);
        assert_eq!(got, blocked, "sheet at {height}");
    }
}

#[test]
fn far_from_the_origin_a_shadow_keeps_its_shape() {
    let shadow_at = |shift: f32| {
        let far = Vec3::new(shift, -shift, shift);
        let scene = scene_of([
            (MeshData::plane(8.0), Transform::from_translation(far)),
            (
                MeshData::cuboid(Vec3::splat(0.5)),
                Transform::from_translation(far + Vec3::Y * 2.0),
            ),
        ]);
        let hits = view(&scene, far + Vec3::new(0.0, 8.0, 0.0), far);
        let mut lamp = point_light(far + Vec3::new(0.0, 6.0, 0.0));
        if let LightShape::Point { position } = &mut lamp.shape {
            *position += DVec3::new(0.53, 0.0, 0.21);
        }
        let image = hard(&scene, &hits, &lamp);
        image
            .values()
            .iter()
            .map(|value| value.to_bits())
            .collect::<Vec<_>>()
    };
    let at_origin = shadow_at(0.0);
    assert!(at_origin.contains(&0));
    // Every coordinate here is exact in f32, so nothing may change.
    assert!(at_origin == shadow_at(65536.0));
    assert!(at_origin == shadow_at(1_048_576.0));
}
