//! Sets of small scenes whose answer is known: tight where they must be, empty and quiet where input is missing or bad.

use crate::sets_harness::judge::judge;
use crate::sets_harness::{Id, Thing, VIEWPORT, random_scene, run, simple, thing, transform};
use antumbra::geometry::Aabb;
use antumbra::scene::{Camera, Light, LightKind, LightSelection};
use antumbra::sets::{FrameLight, FrameLights, FrustumSet, Objects, SetWork, View, ViewportSize};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::{DVec3, Quat, UVec2, Vec3};

fn lamp() -> (Light, Vec3) {
    (Light::point(Vec3::ONE, 1.0, 30.0), Vec3::new(0.0, 6.0, -10.0))
}

fn first_light(world: &World) -> &FrameLight {
    &world.resource::<FrameLights>().lights[0]
}

fn ids(world: &World, set: &fixedbitset::FixedBitSet) -> Vec<usize> {
    let objects = world.resource::<Objects>();
    let mut ids: Vec<_> = set
        .ones()
        .map(|i| world.get::<Id>(objects.entities[i]).unwrap().0)
        .collect();
    ids.sort_unstable();
    ids
}

#[test]
fn a_light_that_nobody_receives_is_skipped() {
    let far = (Light::point(Vec3::ONE, 1.0, 2.0), Vec3::new(50.0, 0.0, -10.0));
    let dark = (Light::point(Vec3::ONE, 0.0, 20.0), Vec3::new(0.0, 0.0, -5.0));
    let (world, _) = run(&simple(
        vec![thing(Vec3::new(0.0, 0.0, -10.0), 1.0)],
        vec![far, dark],
    ));
    for light in &world.resource::<FrameLights>().lights {
        assert!(light.is_skipped() && light.sets.s.is_clear());
        assert!(light.region.scissor.is_none() && light.region.depth_bounds.is_none());
    }
    assert_eq!(world.resource::<SetWork>().shadows, 0);
}

#[test]
fn casters_that_cannot_reach_the_view_are_left_out() {
    let things = vec![
        thing(Vec3::new(0.0, 0.0, -10.0), 1.0),  // receiver in view
        thing(Vec3::new(0.0, 8.0, -10.0), 0.2),  // between light and receiver, out of view
        thing(Vec3::new(0.0, 14.0, -10.0), 0.2), // beyond the light
        thing(Vec3::new(8.0, 8.0, -10.0), 0.2),  // beside
        thing(Vec3::new(0.0, 0.0, 5.0), 0.2),    // behind the camera
    ];
    let light = (Light::point(Vec3::ONE, 1.0, 30.0), Vec3::new(0.0, 12.0, -10.0));
    let (world, _) = run(&simple(things, vec![light]));
    let light = first_light(&world);
    assert!(!light.hulls.inside_frustum);
    assert_eq!(ids(&world, &light.sets.s), [0, 1]);
    assert_eq!(light.sets.l.count_ones(..), 5);
    assert_eq!(ids(&world, &light.sets.i), [0]);
}

#[test]
fn spots_and_rectangles_leave_out_what_is_beside_and_behind() {
    let things = vec![
        thing(Vec3::new(0.0, 0.0, -10.0), 1.0),   // ahead
        thing(Vec3::new(3.0, 0.0, -10.0), 0.5),   // in the half-space, outside the cone
        thing(Vec3::new(0.0, 0.0, 3.0), 1.0),     // behind
        thing(Vec3::new(0.0, 0.0, -25.0), 1.0),   // out of range
        thing(Vec3::new(2.05, 2.05, -10.0), 0.5), // the corner of its box would be inside a square of the cone's size
    ];
    let kind = LightKind::Spot {
        inner_angle: 0.1,
        outer_angle: 0.2,
    };
    let spot = Light {
        kind,
        ..Light::point(Vec3::ONE, 1.0, 20.0)
    };
    let kind = LightKind::Rect {
        width: 1.0,
        height: 1.0,
    };
    let rect = Light { kind, ..spot.clone() };
    let (world, _) = run(&simple(things, vec![(spot, Vec3::ZERO), (rect, Vec3::ZERO)]));
    for light in &world.resource::<FrameLights>().lights {
        let expected = if matches!(light.light.kind, LightKind::Spot { .. }) {
            vec![0]
        } else {
            vec![0, 1, 4]
        };
        assert_eq!(ids(&world, &light.sets.l), expected, "{:?}", light.light.kind);
    }
}

#[test]
fn masks_are_honoured() {
    let mut things = vec![
        thing(Vec3::new(0.0, 0.0, -10.0), 1.0),
        thing(Vec3::new(0.0, 3.0, -10.0), 0.5),
    ];
    things[1].layers = 2;
    for (affects, casts_for, i, s) in [
        (3, 3, vec![0, 1], vec![0, 1]),
        (1, 3, vec![0], vec![0, 1]),
        (3, 1, vec![0, 1], vec![0]),
        (1, 2, vec![0], vec![1]),
        (0, 3, vec![], vec![]),
        (3, 0, vec![0, 1], vec![]),
    ] {
        let mut scene = simple(things.clone(), vec![lamp()]);
        scene.lights[0].2 = LightSelection {
            affects,
            casts_for,
            ..LightSelection::default()
        };
        let (world, _) = run(&scene);
        assert_eq!(
            ids(&world, &first_light(&world).sets.i),
            i,
            "{affects} {casts_for}"
        );
        assert_eq!(
            ids(&world, &first_light(&world).sets.s),
            s,
            "{affects} {casts_for}"
        );
    }
}

#[test]
fn scissor_and_depth_are_tight() {
    // A lamp of 1 m range on a floor that fills the lower half of the picture.
    let floor = Thing {
        aabb: Aabb {
            min: Vec3::new(-50.0, -1.1, -100.0),
            max: Vec3::new(50.0, -1.0, 10.0),
        },
        ..thing(Vec3::ZERO, 1.0)
    };
    let lamp = (Light::point(Vec3::ONE, 1.0, 1.0), Vec3::new(0.0, -0.5, -10.0));
    let (world, _) = run(&simple(vec![floor], vec![lamp]));
    let light = first_light(&world);
    let (scissor, depth) = (light.region.scissor.unwrap(), light.region.depth_bounds.unwrap());
    // The ball is 2 of the 8.3 m that the picture is high at 10 m: 44 pixels; the floor leaves half of its height.
    assert!(scissor.width <= 46 && scissor.height <= 24, "{scissor:?}");
    assert!(depth.near >= 8.9 && depth.far <= 11.1, "{depth:?}");
    assert!((depth.depth_max - 0.1 / 9.0).abs() < 1e-4 && (depth.depth_min - 0.1 / 11.0).abs() < 1e-4);
}

#[test]
fn lights_at_special_places_lose_nothing() {
    let places = [
        Vec3::ZERO,
        Vec3::new(0.0, 0.0, -0.1),
        Vec3::new(0.0, 0.0, -5.0),
        Vec3::new(0.0, 0.0, 5.0),
        Vec3::new(9.0, 0.0, -9.0),
    ];
    for seed in 0..40 {
        for at in places {
            let mut scene = random_scene(seed * 4 + 1);
            let affine = scene.world_from_camera.affine();
            let place = affine.transform_point3(at).as_dvec3();
            scene.lights.truncate(1);
            scene.lights[0].1 = transform(place, scene.world_from_camera.rotation(), Vec3::ONE);
            let (world, _) = run(&scene);
            let wrong = judge(&scene, &world, seed).wrong;
            assert!(wrong.is_empty(), "seed {seed} at {at}: {}", wrong[0]);
        }
    }
}

fn is_empty(world: &World) -> bool {
    let frame = world.resource::<FrameLights>();
    let skipped = |light: &FrameLight| light.is_skipped() && light.sets.s.is_clear();
    world.resource::<FrustumSet>().set.is_clear() && frame.lights.iter().all(skipped)
}

#[test]
fn missing_input_gives_empty_sets_and_no_panic() {
    let things = vec![thing(Vec3::new(0.0, 0.0, -10.0), 1.0)];
    let (world, _) = run(&simple(vec![], vec![lamp()]));
    assert!(is_empty(&world));
    let (world, _) = run(&simple(things.clone(), vec![]));
    assert_eq!(world.resource::<FrustumSet>().set.count_ones(..), 1);
    // A picture of no size, and back.
    let (mut world, mut schedule) = run(&simple(things, vec![lamp()]));
    assert!(!is_empty(&world));
    world.resource_mut::<ViewportSize>().0 = UVec2::new(320, 0);
    schedule.run(&mut world);
    assert!(is_empty(&world) && world.resource::<View>().data.is_none());
    world.resource_mut::<ViewportSize>().0 = VIEWPORT;
    schedule.run(&mut world);
    assert!(!is_empty(&world));
    let camera = world
        .query_filtered::<Entity, With<Camera>>()
        .single(&world)
        .unwrap();
    world.despawn(camera);
    schedule.run(&mut world);
    assert!(is_empty(&world));
}

#[test]
fn bad_cameras_give_no_view_and_strange_ones_lose_nothing() {
    let things = vec![thing(Vec3::new(0.0, 0.0, -10.0), 1.0)];
    let good = Camera::default();
    let flat = transform(DVec3::ZERO, Quat::IDENTITY, Vec3::new(1.0, 0.0, 1.0));
    for (camera, at) in [
        (
            Camera {
                vertical_fov: 0.0,
                ..good
            },
            GlobalTransform::IDENTITY,
        ),
        (
            Camera {
                vertical_fov: f32::NAN,
                ..good
            },
            GlobalTransform::IDENTITY,
        ),
        (Camera { near: 0.0, ..good }, GlobalTransform::IDENTITY),
        (
            Camera {
                aspect: f32::INFINITY,
                ..good
            },
            GlobalTransform::IDENTITY,
        ),
        (good, transform(DVec3::NAN, Quat::IDENTITY, Vec3::ONE)),
        (good, flat),
    ] {
        let mut scene = simple(things.clone(), vec![lamp()]);
        (scene.camera, scene.world_from_camera) = (camera, at);
        let (world, _) = run(&scene);
        assert!(is_empty(&world), "{camera:?}");
    }
    for (vertical_fov, near) in [(1e-5, 1e-6), (3.1, 1e-6), (1e-5, 1e6), (3.1, 5.0)] {
        let mut scene = simple(things.clone(), vec![lamp()]);
        let aspect = 1e-3;
        scene.camera = Camera {
            vertical_fov,
            near,
            aspect,
            ..Camera::default()
        };
        let (world, _) = run(&scene);
        let wrong = judge(&scene, &world, 1).wrong;
        assert!(wrong.is_empty(), "{vertical_fov} {near}: {}", wrong[0]);
    }
}

#[test]
fn the_first_usable_camera_is_the_view() {
    let (mut world, mut schedule) = run(&simple(vec![], vec![]));
    let first = world.resource::<View>().data.as_ref().unwrap().camera;
    world.spawn((Camera::default(), GlobalTransform::from_xyz(1.0, 0.0, 0.0)));
    schedule.run(&mut world);
    assert_eq!(world.resource::<View>().data.as_ref().unwrap().camera, first);
    world.get_mut::<Camera>(first).unwrap().near = f32::NAN;
    schedule.run(&mut world);
    assert_eq!(world.resource::<View>().data.as_ref().unwrap().eye, DVec3::X);
}

#[test]
fn bad_lights_are_skipped_until_they_are_repaired() {
    let nan = (Light::point(Vec3::ONE, 1.0, f32::NAN), Vec3::ZERO);
    let nowhere = (Light::point(Vec3::ONE, 1.0, 9.0), Vec3::NAN);
    let (mut world, mut schedule) = run(&simple(vec![thing(Vec3::NEG_Z * 9.0, 1.0)], vec![nan, nowhere]));
    let count = |world: &World| {
        let frame = world.resource::<FrameLights>();
        (frame.skipped.len(), frame.lights.len())
    };
    assert_eq!(count(&world), (2, 0));
    schedule.run(&mut world);
    assert_eq!(count(&world), (2, 0));
    for mut light in world.query::<&mut Light>().iter_mut(&mut world) {
        light.range = 20.0;
    }
    schedule.run(&mut world);
    assert_eq!(count(&world), (1, 1));
}

#[test]
fn bounds_that_are_empty_or_endless() {
    let mut things = vec![thing(Vec3::new(0.0, 0.0, -10.0), 1.0); 4];
    things[1].aabb = Aabb::EMPTY;
    things[2].aabb.min.x = f32::NAN;
    things[3].aabb = Aabb {
        min: Vec3::NEG_INFINITY,
        max: Vec3::INFINITY,
    };
    let point = Light::point(Vec3::ONE, 1.0, 30.0);
    let kind = LightKind::Spot {
        inner_angle: 0.1,
        outer_angle: 0.3,
    };
    let spot = Light {
        kind,
        ..point.clone()
    };
    let sun = Light::directional(Vec3::ONE, 1.0);
    let lights = vec![
        (point, Vec3::new(0.0, 6.0, -10.0)),
        (spot, Vec3::ZERO),
        (sun, Vec3::ZERO),
    ];
    let (world, _) = run(&simple(things, lights));
    assert_eq!(world.resource::<Objects>().left_out, 2);
    for light in &world.resource::<FrameLights>().lights {
        for set in [&light.sets.l, &light.sets.i, &light.sets.s] {
            assert_eq!(ids(&world, set), [0, 3]);
        }
        assert!(light.region.scissor.is_some() && light.region.depth_bounds.is_some());
    }
}
