//! Sets of what should not be there: a million objects at one point, bounds without numbers, jumps to nowhere, worlds of
//! nothing. All lose nothing and panic nowhere.

use crate::sets_harness::flat::{assert_clusters_hold, assert_flat_tests_agree, large_scene, spawn_thing};
use crate::sets_harness::{Id, Scene, all_sets, run, thing};
use antumbra::geometry::Aabb;
use antumbra::scene::{Light, WorldBounds};
use antumbra::sets::{FrameLights, Objects};
use bevy_ecs::prelude::*;
use glam::Vec3;

#[test]
fn a_million_objects_at_one_point() {
    let at = Vec3::new(0.0, 0.0, -10.0);
    let mut scene = crate::sets_harness::simple(
        vec![thing(at, 0.5); 1_000_000],
        vec![
            (Light::point(Vec3::ONE, 1.0, 30.0), Vec3::new(0.0, 6.0, -10.0)),
            (Light::point(Vec3::ONE, 1.0, 3.0), Vec3::new(0.0, 6.0, -10.0)),
        ],
    );
    scene.things[77].aabb.min.y = f32::NAN;
    let (mut world, mut schedule) = run(&scene);
    let check = |world: &World, moved: usize| {
        let objects = world.resource::<Objects>();
        assert_eq!((objects.len(), objects.left_out), (1_000_000, 1));
        let lights = &world.resource::<FrameLights>().lights;
        for light in lights {
            let count = if light.light.range > 10.0 { 999_999 } else { moved };
            for set in [&light.sets.l, &light.sets.i, &light.sets.s] {
                assert_eq!(set.count_ones(..), count);
            }
        }
    };
    check(&world, 0);
    // A few jump to the other light.
    let mut bounds = world.query::<&mut WorldBounds>();
    for mut bounds in bounds.iter_mut(&mut world).skip(1000).step_by(100_000) {
        bounds.0 = thing(Vec3::new(0.0, 3.9, -10.0), 0.5).aabb;
    }
    schedule.run(&mut world);
    check(&world, 10);
}

#[test]
fn bounds_without_numbers_and_teleports_leave_and_return() {
    let mut scene = large_scene(21, 300);
    let (mut world, mut schedule) = run(&scene);
    let before = all_sets(&world);
    let old: Vec<Aabb> = scene.things.iter().map(|thing| thing.aabb).collect();
    let far = [f32::NAN, f32::INFINITY, 1e30, -3e7];
    for (turn, far) in far.into_iter().enumerate() {
        for (id, mut bounds) in world.query::<(&Id, &mut WorldBounds)>().iter_mut(&mut world) {
            if id.0 % 3 == turn % 3 {
                bounds.0.min += far;
                bounds.0.max += far;
                scene.things[id.0].aabb = bounds.0;
            }
        }
        schedule.run(&mut world);
        assert_clusters_hold(&world);
        assert_flat_tests_agree(&world);
        assert_eq!(all_sets(&world), all_sets(&run(&scene).0), "{far}");
        for (id, mut bounds) in world.query::<(&Id, &mut WorldBounds)>().iter_mut(&mut world) {
            bounds.0 = old[id.0];
            scene.things[id.0].aabb = bounds.0;
        }
        schedule.run(&mut world);
        assert_eq!(all_sets(&world), before, "back from {far}");
    }
}

#[test]
fn worlds_are_filled_and_emptied() {
    let scene = large_scene(2, 200);
    let empty = Scene {
        things: Vec::new(),
        ..scene.clone()
    };
    let (mut world, mut schedule) = run(&empty);
    assert!(world.resource::<Objects>().is_empty());
    for (id, thing) in scene.things.iter().enumerate() {
        spawn_thing(&mut world, id, thing);
    }
    schedule.run(&mut world);
    assert_eq!(all_sets(&world), all_sets(&run(&scene).0));
    let entities: Vec<Entity> = world.resource::<Objects>().entities.clone();
    for entity in entities {
        world.despawn(entity);
    }
    schedule.run(&mut world);
    assert!(world.resource::<Objects>().is_empty());
    assert_eq!(all_sets(&world), all_sets(&run(&empty).0));
}
