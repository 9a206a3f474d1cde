//! Which entities are seen, block and receive; cameras; what is dropped; nothing panics.

use std::sync::Arc;

use antumbra::reference::{
    LightSource, PrimaryCulling, RayScene, ReferenceError, camera_rays, hard_visibility, primary_hits,
    primary_hits_culled, soft_visibility,
};
use antumbra::scene::{
    AlphaMode, Camera, Light, LightKind, LightSelection, Material, MeshData, PosedMesh, SceneMaterials,
    SelectionLayers, ShadowCaster, ShadowReceiver,
};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Affine3A, DVec3, Mat3A, UVec2, Vec3, Vec3A};
use smallvec::smallvec;

use super::harness::*;

const EYE: Vec3 = Vec3::new(0.0, 6.0, 5.0);

/// A floor under a lid that shadows all of it.
fn floor_and_lid() -> (World, Entity, Entity) {
    let mut world = World::new();
    let floor = spawn(&mut world, MeshData::plane(4.0), Transform::IDENTITY);
    let lid = spawn(
        &mut world,
        MeshData::plane(40.0),
        Transform::from_xyz(0.0, 8.0, 0.0),
    );
    (world, floor, lid)
}

fn overhead() -> LightSource {
    light(LightKind::Directional, Vec3::Y * 20.0, Vec3::ZERO)
}

fn seen(world: &mut World, light: &LightSource) -> antumbra::reference::VisibilityImage {
    let scene = RayScene::from_world(world);
    let hits = view(&scene, EYE, Vec3::ZERO);
    hard_visibility(&scene, &hits, light)
}

#[test]
fn only_casters_on_selected_layers_block() {
    let (mut world, _, lid) = floor_and_lid();
    assert_all(&seen(&mut world, &overhead()), 0.0);
    world.entity_mut(lid).insert(SelectionLayers(0b100));
    let mut light = overhead();
    light.selection.casts_for = 0b011;
    assert_all(&seen(&mut world, &light), 1.0);
    light.selection.casts_for = 0b110;
    assert_all(&seen(&mut world, &light), 0.0);
    world.entity_mut(lid).remove::<ShadowCaster>();
    assert_all(&seen(&mut world, &light), 1.0);
}

#[test]
fn receivers_that_are_not_selected_do_not_count_and_non_receivers_are_lit() {
    let (mut world, floor, _) = floor_and_lid();
    let mut light = overhead();
    light.selection.affects = 0b10;
    assert_eq!(seen(&mut world, &light).counted(), 0);
    world.entity_mut(floor).insert(SelectionLayers(0b10));
    assert_all(&seen(&mut world, &light), 0.0);
    world.entity_mut(floor).remove::<ShadowReceiver>();
    assert_all(&seen(&mut world, &light), 1.0);
}

#[test]
fn blended_meshes_are_seen_bare_ones_are_not_and_both_block() {
    let (mut world, floor, lid) = floor_and_lid();
    let glass = Material {
        alpha_mode: AlphaMode::Blend,
        ..Material::default()
    };
    world
        .entity_mut(lid)
        .insert((Transform::IDENTITY, GlobalTransform::from_xyz(0.0, 1.0, 0.0)));
    world
        .entity_mut(lid)
        .insert(SceneMaterials(smallvec![Arc::new(glass)]));
    assert_all(&seen(&mut world, &overhead()), 1.0); // the glass itself, before the floor in its shadow
    world.entity_mut(lid).remove::<SceneMaterials>();
    assert_all(&seen(&mut world, &overhead()), 0.0);
    world.entity_mut(floor).remove::<SceneMaterials>();
    assert_eq!(seen(&mut world, &overhead()).counted(), 0);
}

#[test]
fn a_posed_mesh_replaces_the_mesh_unless_it_is_empty() {
    let (mut world, _, lid) = floor_and_lid();
    world.entity_mut(lid).insert(PosedMesh::default());
    assert_all(&seen(&mut world, &overhead()), 0.0);
    let positions = MeshData::plane(1.0)
        .positions
        .iter()
        .map(|p| *p + Vec3::X * 100.0)
        .collect();
    world.entity_mut(lid).insert(PosedMesh {
        positions,
        ..PosedMesh::default()
    });
    assert_all(&seen(&mut world, &overhead()), 1.0);
}

#[test]
fn unusable_objects_are_left_out_and_bad_triangles_counted() {
    let (mut world, _, lid) = floor_and_lid();
    for column in [Vec3A::ZERO, Vec3A::NAN, Vec3A::INFINITY] {
        let matrix = Mat3A::from_cols(column, Vec3A::Y, Vec3A::Z);
        let affine = Affine3A::from_mat3_translation(matrix.into(), Vec3::Y * 8.0);
        world.entity_mut(lid).insert(GlobalTransform::from(affine));
        assert_all(&seen(&mut world, &overhead()), 1.0);
    }
    let mut bad = MeshData::cuboid(Vec3::ONE);
    bad.positions[0] = Vec3::NAN;
    bad.positions[5] = Vec3::INFINITY;
    bad.indices[35] = 999;
    spawn(&mut world, bad, Transform::from_xyz(500.0, 0.0, 0.0));
    let scene = RayScene::from_world(&mut world);
    assert_eq!((scene.triangles().len(), scene.dropped_count()), (10, 4));
}

#[test]
fn mirrored_objects_keep_their_outside_and_their_shadow() {
    let plain = Transform::from_xyz(0.3, 1.0, 0.2).with_scale(Vec3::new(1.0, 0.7, 0.5));
    let mirrored = plain.with_scale(plain.scale * Vec3::new(-1.0, 1.0, 1.0));
    let floor = || (MeshData::plane(6.0), Transform::IDENTITY);
    let [a, b] = [plain, mirrored].map(|transform| {
        let scene = scene_of([floor(), (MeshData::cuboid(Vec3::ONE), transform)]);
        let view = |eye, target, culling| {
            primary_hits_culled(&scene, &camera(), &looking_at(eye, target), SIZE, culling).unwrap()
        };
        let outside = [PrimaryCulling::None, PrimaryCulling::SingleSided].map(|c| view(EYE, Vec3::ZERO, c));
        for (all, front) in outside[0].hits.iter().zip(&outside[1].hits) {
            assert_eq!(all, front, "from outside culling changes nothing");
        }
        // From the inside a single-sided box is not seen; the ceiling of this view is the sky.
        let inside = Vec3::new(0.3, 1.0, 0.2);
        let up = view(inside, inside + Vec3::Y, PrimaryCulling::SingleSided);
        assert!(up.hits.iter().all(Option::is_none));
        let up = view(inside, inside + Vec3::Y, PrimaryCulling::None);
        assert!(up.hits.iter().all(Option::is_some));
        let shadow = hard(&scene, &outside[0], &point_light(Vec3::new(2.0, 5.0, 1.0)));
        (outside[0].clone(), shadow)
    });
    for (a, b) in a.0.hits.iter().zip(&b.0.hits) {
        let near = match (a, b) {
            (Some(a), Some(b)) => {
                a.position.distance(b.position) < 1e-6 && a.normal.dot(b.normal) > 0.999_999
            }
            (a, b) => a.is_none() && b.is_none(),
        };
        assert!(near, "{a:?} {b:?}");
    }
    let different =
        a.1.values()
            .iter()
            .zip(b.1.values())
            .filter(|(a, b)| a.total_cmp(b).is_ne())
            .count();
    assert_eq!(different, 0);
}

#[test]
fn a_double_sided_material_is_seen_from_behind() {
    let mut world = World::new();
    let plane = spawn(&mut world, MeshData::plane(40.0), Transform::IDENTITY);
    let from_below = |world: &mut World| {
        let scene = RayScene::from_world(world);
        let below = looking_at(-Vec3::Y, Vec3::ZERO);
        let hits = primary_hits_culled(&scene, &camera(), &below, SIZE, PrimaryCulling::SingleSided).unwrap();
        hits.hits.iter().flatten().count()
    };
    assert_eq!(from_below(&mut world), 0);
    let material = Material {
        double_sided: true,
        ..Material::default()
    };
    world
        .entity_mut(plane)
        .insert(SceneMaterials(smallvec![Arc::new(material)]));
    assert_eq!(from_below(&mut world), (SIZE.x * SIZE.y) as usize);
}

#[test]
fn pixels_are_where_the_projection_puts_them() {
    let scene = scene_of([(MeshData::plane(50.0), Transform::IDENTITY)]);
    let world_from_camera = looking_at(Vec3::new(1.0, 4.0, 3.0), Vec3::new(0.0, 0.0, -1.0));
    let hits = primary_hits(&scene, &camera(), &world_from_camera, SIZE).unwrap();
    let clip_from_world = camera().clip_from_view() * Camera::view_from_world(&world_from_camera).unwrap();
    let mut count = 0;
    for (index, hit) in hits.hits.iter().enumerate() {
        let Some(hit) = hit else { continue };
        let clip = clip_from_world * hit.position.extend(1.0);
        let (x, y) = (index as u32 % SIZE.x, index as u32 / SIZE.x);
        let pixel_x = (clip.x / clip.w + 1.0) * 0.5 * f64::from(SIZE.x);
        let pixel_y = (1.0 - clip.y / clip.w) * 0.5 * f64::from(SIZE.y);
        assert!((pixel_x - f64::from(x) - 0.5).abs() < 1e-4, "{pixel_x} for {x}");
        assert!((pixel_y - f64::from(y) - 0.5).abs() < 1e-4, "{pixel_y} for {y}");
        assert!((clip.w - hit.view_depth).abs() < 1e-5 && hit.normal.y > 0.999);
        count += 1;
    }
    assert!(count > 1000);
}

#[test]
fn what_lies_before_the_near_plane_is_not_seen_but_blocks() {
    let scene = scene_of([
        (MeshData::plane(40.0), Transform::IDENTITY),
        (MeshData::plane(40.0), Transform::from_xyz(0.0, 1.0, 0.0)),
    ]);
    let down = looking_at(Vec3::Y * 2.0, Vec3::ZERO);
    for (near, height) in [(0.999, 1.0), (1.001, 0.0)] {
        let camera = Camera { near, ..camera() };
        let hits = primary_hits(&scene, &camera, &down, SIZE).unwrap();
        // The near plane is a plane: at the corners too, where the distance is larger.
        assert!(
            hits.hits
                .iter()
                .flatten()
                .all(|hit| (hit.position.y - height).abs() < 1e-9)
        );
        assert_eq!(hits.hits.iter().flatten().count(), (SIZE.x * SIZE.y) as usize);
        assert_all(&hard(&scene, &hits, &point_light(Vec3::Y * 1.5)), height as f32);
    }
}

#[test]
fn nothing_in_nothing_out() {
    let empty = RayScene::from_world(&mut World::new());
    let hits = view(&empty, EYE, Vec3::ZERO);
    assert_eq!(hits.hits, vec![None; (SIZE.x * SIZE.y) as usize]);
    assert_eq!(hard(&empty, &hits, &overhead()).counted(), 0);
    let scene = scene_of([(MeshData::plane(1.0), Transform::IDENTITY)]);
    let none = primary_hits(&scene, &camera(), &looking_at(EYE, Vec3::ZERO), UVec2::new(0, 7)).unwrap();
    assert!(
        none.hits.is_empty()
            && soft_visibility(&scene, &none, &overhead(), 0, 0)
                .values()
                .is_empty()
    );
}

#[test]
fn bad_cameras_and_lights_are_errors() {
    let scene = scene_of([(MeshData::plane(1.0), Transform::IDENTITY)]);
    let here = GlobalTransform::IDENTITY;
    for bad in [f32::NAN, 0.0, -1.0, f32::INFINITY] {
        for camera in [
            Camera {
                near: bad,
                ..camera()
            },
            Camera {
                aspect: bad,
                ..camera()
            },
            Camera {
                vertical_fov: bad,
                ..camera()
            },
        ] {
            let error = camera_rays(&camera, &here, SIZE).unwrap_err();
            assert!(matches!(error, ReferenceError::Camera { .. }));
        }
        let nowhere = GlobalTransform::from(Affine3A::from_scale(Vec3::new(bad.min(0.0), 0.0, 1.0)));
        let error = primary_hits(&scene, &camera(), &nowhere, SIZE).unwrap_err();
        assert_eq!(error, ReferenceError::CameraTransform);
        if bad != 0.0 {
            let lamp = Light::point(Vec3::ONE, bad, 1.0);
            assert!(LightSource::new(&lamp, &here, LightSelection::default()).is_err());
        }
    }
    let lost = GlobalTransform::from_translation(Vec3::NAN);
    let lamp = Light::point(Vec3::ONE, 1.0, 1.0);
    assert!(LightSource::new(&lamp, &lost, LightSelection::default()).is_err());
    let mut world = World::new();
    let entity = world.spawn(here).id();
    let error = LightSource::of_entity(&world, entity).unwrap_err();
    assert_eq!(error, ReferenceError::NotALight(entity));
    world.entity_mut(entity).insert(lamp);
    assert!(LightSource::of_entity(&world, entity).is_ok());
    world.despawn(entity);
    assert!(LightSource::of_entity(&world, entity).is_err());
}

#[test]
fn absurd_numbers_are_dropped_or_survived() {
    let x = DVec3::X;
    let huge = RayScene::from_triangles([
        [x * 1e16, x, DVec3::Y],
        [DVec3::NAN, x, DVec3::Y],
        [x * 1e14, -x * 1e14, DVec3::Y * 1e14],
    ]);
    assert_eq!((huge.triangles().len(), huge.dropped_count()), (1, 2));
    for bad in [DVec3::NAN, DVec3::INFINITY, DVec3::ZERO, x * 1e-310, x * 1e300] {
        huge.blocks_direction(DVec3::ONE, bad, None, 1);
        huge.blocks_segment(bad, DVec3::ONE, None, 1);
        huge.blocks_segment(DVec3::ONE, bad, Some(99), 1);
    }
    let same = [DVec3::ONE; 3];
    let points = RayScene::from_triangles(vec![same; 500]);
    assert!(!points.blocks_segment(DVec3::ZERO, DVec3::splat(2.0), None, u32::MAX));
}
