//! Sets of many objects: the hierarchy finds what flat tests find, frame after frame, on one thread and on many.

use std::collections::BTreeMap;

use crate::sets_harness::flat::{
    assert_clusters_hold, assert_flat_tests_agree, large_scene, random_thing, spawn_thing,
};
use crate::sets_harness::judge::judge;
use crate::sets_harness::{Id, Random, Scene, Thing, all_sets, run, thing, transform};
use antumbra::geometry::Aabb;
use antumbra::scene::{Light, ShadowCaster, WorldBounds};
use antumbra::sets::{FrameLights, Objects, SetWork, ViewportSize};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::{DVec3, Quat, UVec2, Vec3};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..Default::default() })]

    #[test]
    fn boxes_around_boxes_find_what_flat_tests_find(seed in any::<u64>()) {
        let (world, _) = run(&large_scene(seed, 900));
        assert_clusters_hold(&world);
        assert_flat_tests_agree(&world);
    }

    #[test]
    fn objects_that_move_come_and_go_leave_the_sets_of_a_fresh_world(seed in any::<u64>()) {
        let mut scene = large_scene(seed, 400);
        let origin = scene.world_from_camera.translation().as_dvec3();
        let (mut world, mut schedule) = run(&scene);
        let mut random = Random::new(seed ^ 3);
        for frame in 0..8 {
            change(&mut scene, &mut world, &mut random, origin, frame);
            world.clear_trackers();
            schedule.run(&mut world);
            let (fresh, _) = run(&living(&scene));
            prop_assert_eq!(by_place(&world, &scene), by_place(&fresh, &living(&scene)), "frame {}", frame);
            assert_clusters_hold(&world);
            assert_flat_tests_agree(&world);
        }
    }
}

/// A thing that was removed; its place in the list stays.
fn is_gone(thing: &Thing) -> bool {
    thing.layers == 0
}

fn living(scene: &Scene) -> Scene {
    let mut living = scene.clone();
    living.things.retain(|thing| !is_gone(thing));
    living
}

/// Moves some things a little, some far, spawns and despawns, and takes and gives roles within one frame.
fn change(scene: &mut Scene, world: &mut World, random: &mut Random, origin: DVec3, frame: usize) {
    let entities: BTreeMap<usize, Entity> = world
        .query::<(&Id, Entity)>()
        .iter(world)
        .map(|(id, entity)| (id.0, entity))
        .collect();
    for (&i, &entity) in &entities {
        let kind = random.unit();
        let aabb = &mut scene.things[i].aabb;
        if kind < 0.02 {
            *aabb = random_thing(random, origin).aabb; // to anywhere
        } else if kind < 0.3 && frame % 3 != 2 {
            let by = random.vec(1.0).as_vec3();
            *aabb = Aabb {
                min: aabb.min + by,
                max: aabb.max + by,
            };
        } else {
            continue;
        }
        world.get_mut::<WorldBounds>(entity).unwrap().0 = *aabb;
    }
    let mut living = entities.iter();
    if frame.is_multiple_of(2) {
        for (&i, &entity) in living.by_ref().step_by(17).take(5) {
            scene.things[i].layers = 0;
            world.despawn(entity);
        }
        for _ in 0..5 {
            let thing = random_thing(random, origin);
            spawn_thing(world, scene.things.len(), &thing);
            scene.things.push(thing);
        }
    }
    // One gains what another loses: the counts stay.
    let pair = living.find(|(i, _)| scene.things[**i].caster).zip(
        entities
            .iter()
            .rev()
            .find(|(i, _)| !scene.things[**i].caster && !is_gone(&scene.things[**i])),
    );
    if let Some(((&loses, &from), (&gains, &to))) = pair {
        world.entity_mut(from).remove::<ShadowCaster>();
        world.entity_mut(to).insert(ShadowCaster);
        scene.things[loses].caster = false;
        scene.things[gains].caster = true;
    }
}

/// F, and L, I, S of each light with its bounds, by the place of a thing among the living.
fn by_place(world: &World, scene: &Scene) -> (Vec<usize>, Vec<(String, [Vec<usize>; 3])>) {
    let mut living = 0;
    let place: Vec<usize> = scene
        .things
        .iter()
        .map(|thing| {
            living += usize::from(!is_gone(thing));
            living
        })
        .collect();
    let (f, lights) = all_sets(world);
    let places = |ids: Vec<usize>| ids.into_iter().map(|id| place[id]).collect::<Vec<_>>();
    let lights = lights
        .into_iter()
        .map(|(bounds, sets)| (bounds, sets.map(places)));
    (places(f), lights.collect())
}

#[test]
fn an_order_spoilt_by_motion_is_renewed_and_changes_no_set() {
    let mut scene = large_scene(12, 600);
    scene.things.retain(|thing| !thing.aabb.is_empty()); // to the judge they would block everything
    for thing in &mut scene.things {
        thing.aabb = crate::sets_harness::thing(thing.aabb.center(), 0.2).aabb;
    }
    let (mut world, mut schedule) = run(&scene);
    let layout = world.resource::<Objects>().layout_generation;
    let mut random = Random::new(5);
    let mut renewed = Vec::new();
    for frame in 0..400 {
        for (_, mut bounds) in world.query::<(&Id, &mut WorldBounds)>().iter_mut(&mut world) {
            let by = random.vec(0.5).as_vec3();
            bounds.0.min += by;
            bounds.0.max += by;
        }
        schedule.run(&mut world);
        let objects = world.resource::<Objects>();
        if objects.layout_generation != layout + renewed.len() as u64 {
            renewed.push(frame);
            assert_clusters_hold(&world);
            assert_flat_tests_agree(&world);
            let objects = world.resource::<Objects>();
            for (index, &entity) in objects.entities.iter().enumerate() {
                assert_eq!(objects.index_of(entity), Some(index));
            }
        }
    }
    assert!(!renewed.is_empty() && renewed.len() <= 3, "{renewed:?}");
    assert!(
        renewed.windows(2).all(|pair| pair[1] - pair[0] >= 120),
        "{renewed:?}"
    );
    for (id, bounds) in world.query::<(&Id, &WorldBounds)>().iter(&world) {
        scene.things[id.0].aabb = bounds.0;
    }
    assert_eq!(all_sets(&world), all_sets(&run(&scene).0));
    let wrong = judge(&scene, &world, 1).wrong;
    assert!(wrong.is_empty(), "{}", wrong[0]);
}

#[test]
fn cost_follows_what_moved() {
    let mut scene = crate::sets_harness::simple(Vec::new(), Vec::new());
    for x in 0..40 {
        for z in 0..200 {
            let at = Vec3::new(x as f32 - 20.0, -1.0, -z as f32) * 3.0;
            scene.things.push(thing(at, 0.5));
        }
    }
    for i in 0..16 {
        let at = DVec3::new(0.0, 1.0, -30.0 * f64::from(i));
        let light = Light::point(Vec3::ONE, 1.0, 5.0);
        scene.lights.push((
            light,
            transform(at, Quat::IDENTITY, Vec3::ONE),
            Default::default(),
        ));
    }
    let (mut world, mut schedule) = run(&scene);
    world.resource_mut::<ViewportSize>().0 = UVec2::new(640, 360);
    schedule.run(&mut world);
    let words = world.resource::<Objects>().boxes.words() as u64;
    let before = *world.resource::<SetWork>();
    for (id, mut bounds) in world.query::<(&Id, &mut WorldBounds)>().iter_mut(&mut world) {
        if id.0 == 4000 {
            bounds.0.max.y += 0.1;
        }
    }
    schedule.run(&mut world);
    let after = *world.resource::<SetWork>();
    assert_eq!(after.objects_written - before.objects_written, 1);
    assert!(after.frustum_words - before.frustum_words <= 1);
    assert!(after.light_words - before.light_words <= 2, "{words} words");
    assert!(after.illuminations - before.illuminations <= 2);
    // All lights: none asks more than the few words around it.
    for mut transform in world
        .query_filtered::<&mut GlobalTransform, With<Light>>()
        .iter_mut(&mut world)
    {
        let moved = transform.translation() + Vec3::X;
        *transform = GlobalTransform::from_translation(moved);
    }
    schedule.run(&mut world);
    let tested = world.resource::<SetWork>().light_words - after.light_words;
    assert!(
        tested > 0 && tested < 16 * 12 && words > 120,
        "{tested} of {words}"
    );
}

#[test]
fn flat_tests_tell_a_lost_object() {
    let (mut world, _) = run(&large_scene(1, 300));
    let lights = &mut world.resource_mut::<FrameLights>().lights;
    let light = lights
        .iter_mut()
        .find(|light| !light.sets.reach.is_clear())
        .unwrap();
    let lost = light.sets.reach.ones().next().unwrap();
    light.sets.reach.remove(lost);
    let told = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| assert_flat_tests_agree(&world)));
    assert!(told.is_err());
}
