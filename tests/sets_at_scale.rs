//! Sets of many objects: the hierarchy finds what flat tests find, frame after frame, on one thread and on many.

mod sets_harness;

use std::collections::BTreeMap;

use antumbra::geometry::Aabb;
use antumbra::scene::{Light, SceneMaterials, ShadowCaster, ShadowReceiver, WorldBounds};
use antumbra::sets::boxes::WORD;
use antumbra::sets::{
    FrameLight, FrameLights, FrustumSet, LightVolume, Objects, SetWork, View, ViewportSize,
};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::{DVec3, Quat, UVec2, Vec3};
use proptest::prelude::*;
use sets_harness::judge::judge;
use sets_harness::{Id, Random, Scene, Thing, all_sets, random_scene, run, thing, transform};

/// A scene of `count` boxes of very different sizes, some without any, and the lights of a random scene; far from the
/// origin as often as those.
fn large_scene(seed: u64, count: usize) -> Scene {
    let mut scene = random_scene(seed);
    let origin = scene.world_from_camera.translation().as_dvec3();
    let mut random = Random(seed ^ 0xfeed);
    scene.things = (0..count).map(|_| random_thing(&mut random, origin)).collect();
    scene
}

fn random_thing(random: &mut Random, origin: DVec3) -> Thing {
    let center = origin + random.vec(30.0);
    let half = random.range(0.0, 1.0).powi(8) * 20.0;
    let mut aabb = thing(center.as_vec3(), half as f32).aabb;
    if random.chance(0.02) {
        aabb = Aabb::EMPTY;
    }
    Thing {
        aabb,
        caster: random.chance(0.8),
        receiver: random.chance(0.8),
        drawn: random.chance(0.8),
        layers: 1 << random.below(2),
    }
}

/// F and the reach of every light, by asking all boxes, have the bits that the world has.
fn assert_flat_tests_agree(world: &World) {
    let objects = world.resource::<Objects>();
    let present = objects.present.as_slice();
    let view = world.resource::<View>().data.as_ref().unwrap();
    let f = world.resource::<FrustumSet>().set.as_slice();
    for word in 0..objects.boxes.words() {
        let flat = objects
            .boxes
            .touching_planes(word, present[word], &view.frustum.planes);
        assert_eq!(f[word], flat, "F, word {word}");
    }
    for light in &world.resource::<FrameLights>().lights {
        for (word, &present) in present.iter().enumerate() {
            let flat = match &light.volume {
                LightVolume::Infinite => present,
                LightVolume::Ball(ball) => objects.boxes.touching_sphere(word, present, ball),
                LightVolume::Cone(cone) | LightVolume::HalfBall(cone) => {
                    objects.boxes.touching_cone(word, present, cone)
                }
            };
            let reach = light.reach.as_slice()[word];
            assert_eq!(reach, flat, "{:?}, word {word}", light.volume);
            assert!(light.l.as_slice()[word] & !reach == 0);
            assert!((light.i.as_slice()[word] | light.s.as_slice()[word]) & !light.l.as_slice()[word] == 0);
        }
        assert_shadow_set(world, light, f);
    }
}

/// S has the bits that both hulls leave, box by box.
fn assert_shadow_set(world: &World, light: &FrameLight, f: &[usize]) {
    let objects = world.resource::<Objects>();
    for (word, &l) in light.l.as_slice().iter().enumerate() {
        let mut s = l & objects.casters.as_slice()[word];
        if light.scissor.is_none() || light.receiver_hull.planes.planes.is_empty() {
            continue;
        }
        if light.inside_frustum {
            s &= f[word];
        } else {
            s = objects.boxes.touching_planes(word, s, &light.hull.planes);
        }
        s = objects
            .boxes
            .touching_planes(word, s, &light.receiver_hull.planes);
        for bit in 0..WORD {
            let layers = objects.layers.get(word * WORD + bit).copied().unwrap_or_default();
            if layers & light.selection.casts_for == 0 {
                s &= !(1 << bit);
            }
        }
        assert_eq!(
            light.s.as_slice()[word],
            s,
            "S of {:?}, word {word}",
            light.volume
        );
    }
}

/// Boxes of clusters and blocks hold all that they must.
fn assert_clusters_hold(world: &World) {
    let objects = world.resource::<Objects>();
    let (words, blocks) = (&objects.clusters.words, &objects.clusters.blocks);
    let holds = |outer: Aabb, inner: Aabb| {
        inner.is_empty() || (outer.min.cmple(inner.min).all() && inner.max.cmple(outer.max).all())
    };
    for index in 0..objects.len() {
        let aabb = objects.boxes.get(index);
        assert!(holds(words.get(index / WORD), aabb), "object {index}");
        assert_eq!(objects.present.contains(index), !aabb.is_empty());
    }
    for word in 0..words.len() {
        assert!(holds(blocks.get(word / WORD), words.get(word)), "word {word}");
    }
}

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
        let mut random = Random(seed ^ 3);
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

fn spawn_thing(world: &mut World, id: usize, thing: &Thing) {
    let layers = antumbra::scene::SelectionLayers(thing.layers);
    let mut entity = world.spawn((Id(id), WorldBounds(thing.aabb), layers, GlobalTransform::IDENTITY));
    if thing.caster {
        entity.insert(ShadowCaster);
    }
    if thing.receiver {
        entity.insert(ShadowReceiver);
    }
    if thing.drawn {
        entity.insert(SceneMaterials(Default::default()));
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
        thing.aabb = sets_harness::thing(thing.aabb.center(), 0.2).aabb;
    }
    let (mut world, mut schedule) = run(&scene);
    let layout = world.resource::<Objects>().layout_generation;
    let mut random = Random(5);
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
fn a_million_objects_at_one_point() {
    let at = Vec3::new(0.0, 0.0, -10.0);
    let mut scene = sets_harness::simple(
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
            for set in [&light.l, &light.i, &light.s] {
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

#[test]
fn cost_follows_what_moved() {
    let mut scene = sets_harness::simple(Vec::new(), Vec::new());
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
    let light = lights.iter_mut().find(|light| !light.reach.is_clear()).unwrap();
    let lost = light.reach.ones().next().unwrap();
    light.reach.remove(lost);
    let told = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| assert_flat_tests_agree(&world)));
    assert!(told.is_err());
}
