//! The sets may keep too many, they never drop what matters: held against brute force over sampled points and rays.

mod sets_harness;

use antumbra::geometry::Aabb;
use antumbra::scene::{Camera, Light, LightKind, LightSelection, ShadowCaster, WorldBounds};
use antumbra::sets::{FrameLight, FrameLights, FrustumSet, Objects, SetWork, View, ViewportSize};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::{DVec3, Quat, UVec2, Vec3};
use proptest::prelude::*;
use sets_harness::judge::judge;
use sets_harness::{
    Id, Random, Thing, VIEWPORT, all_sets, random_scene, rooms, run, simple, spawn, thing, transform,
};

proptest! {
    #![proptest_config(ProptestConfig { cases: 192, failure_persistence: None, ..Default::default() })]

    #[test]
    fn nothing_seen_by_brute_force_is_missing(seed in any::<u64>()) {
        let scene = random_scene(seed);
        let (world, _) = run(&scene);
        let wrong = judge(&scene, &world, seed).wrong;
        prop_assert!(wrong.is_empty(), "{} missing, first: {}", wrong.len(), wrong[0]);
    }

    #[test]
    fn incremental_frames_equal_fresh_ones(seed in any::<u64>()) {
        let mut scene = random_scene(seed);
        let (mut world, mut schedule) = run(&scene);
        let mut random = Random(seed ^ 77);
        for frame in 0..4 {
            for _ in 0..3 {
                let i = random.below(scene.things.len());
                let by = random.vec(4.0).as_vec3();
                let old = scene.things[i].aabb;
                let moved = Aabb { min: old.min + by, max: old.max + by };
                let aabb = if random.chance(0.1) { Aabb::EMPTY } else { moved };
                scene.things[i].aabb = aabb;
                let mut things = world.query::<(&Id, &mut WorldBounds)>();
                let mut found = things.iter_mut(&mut world).filter(|(id, _)| id.0 == i);
                found.next().unwrap().1.0 = aabb;
            }
            if frame == 2 {
                let mut lights = world.query_filtered::<(Entity, &GlobalTransform), With<Light>>();
                let first = lights.iter(&world).find(|(_, at)| **at == scene.lights[0].1).unwrap().0;
                scene.lights[0].1 = transform(random.vec(5.0), random.rotation(), Vec3::ONE);
                *world.get_mut::<GlobalTransform>(first).unwrap() = scene.lights[0].1;
            }
            world.clear_trackers();
            schedule.run(&mut world);
            let (fresh, _) = run(&scene);
            prop_assert_eq!(all_sets(&world), all_sets(&fresh));
        }
    }
}

#[test]
fn brute_force_finds_a_caster_that_is_taken_out() {
    let (mut found, mut blocked) = (0, 0);
    for seed in 0..8 {
        let scene = random_scene(seed);
        let (mut world, _) = run(&scene);
        for light in &mut world.resource_mut::<FrameLights>().lights {
            light.s.clear();
        }
        let verdict = judge(&scene, &world, seed);
        found += verdict
            .wrong
            .iter()
            .filter(|line| line.contains("not in S"))
            .count();
        blocked += verdict.blocked;
    }
    assert!(
        found == blocked && found > 1000,
        "{found} of {blocked}: the judge sees too little"
    );
}

#[test]
fn brute_force_finds_every_other_loss() {
    type Spoil = (&'static str, fn(&mut World));
    let spoil: [Spoil; 5] = [
        ("not in F or V", |world| {
            world.resource_mut::<FrustumSet>().set.clear()
        }),
        ("not in L", |world| each_light(world, |light| light.l.clear())),
        ("not in I", |world| each_light(world, |light| light.i.clear())),
        ("pixel", |world| {
            each_light(world, |light| {
                if let Some(scissor) = &mut light.scissor {
                    scissor.width = scissor.width.div_ceil(2);
                }
            })
        }),
        ("depth", |world| {
            each_light(world, |light| {
                if let Some(depth) = &mut light.depth_bounds {
                    depth.depth_min = depth.depth_max.midpoint(depth.depth_min);
                }
            })
        }),
    ];
    for (name, spoil) in spoil {
        let found = (0..8).map(|seed| {
            let scene = random_scene(seed);
            let (mut world, _) = run(&scene);
            spoil(&mut world);
            let wrong = judge(&scene, &world, seed).wrong;
            wrong.iter().filter(|line| line.contains(name)).count()
        });
        let found: usize = found.sum();
        assert!(found > 100, "{found} found of {name}");
    }
}

fn each_light(world: &mut World, spoil: fn(&mut FrameLight)) {
    world
        .resource_mut::<FrameLights>()
        .lights
        .iter_mut()
        .for_each(spoil);
}

#[test]
fn sets_do_not_depend_on_spawn_order() {
    for seed in 0..32u64 {
        let scene = random_scene(seed);
        let mut random = Random(seed + 999);
        let mut order: Vec<usize> = (0..scene.things.len()).collect();
        for i in (1..order.len()).rev() {
            order.swap(i, random.below(i + 1));
        }
        let (ordered, _) = run(&scene);
        let (mut shuffled, mut schedule) = spawn(&scene, &order);
        schedule.run(&mut shuffled);
        assert_eq!(all_sets(&ordered), all_sets(&shuffled), "seed {seed}");
    }
}

#[test]
fn steady_frame_computes_nothing() {
    let (mut world, mut schedule) = run(&random_scene(3));
    let before = *world.resource::<SetWork>();
    assert!(before.frustum_words > 0 && before.light_words > 0);
    assert!(before.illuminations > 0 && before.shadows > 0);
    for _ in 0..3 {
        world.clear_trackers();
        schedule.run(&mut world);
    }
    assert_eq!(*world.resource::<SetWork>(), before);
    // A light that flickers changes no set either, and the frame has its new intensity.
    for mut light in world.query::<&mut Light>().iter_mut(&mut world) {
        light.intensity *= 0.5;
    }
    schedule.run(&mut world);
    assert_eq!(*world.resource::<SetWork>(), before);
    let frame = world.resource::<FrameLights>();
    assert!(frame.lights.iter().all(|light| light.light.intensity == 0.5));
}

#[test]
fn markers_and_despawns_reach_the_sets() {
    let (mut world, mut schedule) = run(&random_scene(5));
    let layout = world.resource::<Objects>().layout_generation;
    let casters = world.resource::<Objects>().casters.count_ones(..);
    let mut query = world.query_filtered::<Entity, With<ShadowCaster>>();
    let caster = query.iter(&world).next().unwrap();
    world.entity_mut(caster).remove::<ShadowCaster>();
    schedule.run(&mut world);
    let objects = world.resource::<Objects>();
    assert_eq!(objects.casters.count_ones(..), casters - 1);
    assert_eq!(objects.layout_generation, layout);
    world.despawn(caster);
    schedule.run(&mut world);
    let objects = world.resource::<Objects>();
    assert_eq!(objects.len(), 39);
    assert_eq!(objects.layout_generation, layout + 1);
    assert_eq!(objects.index_of(caster), None);
    for (index, &entity) in objects.entities.iter().enumerate() {
        assert_eq!(objects.index_of(entity), Some(index));
    }
    assert!(objects.entities.is_sorted());
}

// ---- small scenes with known answers ----

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
        assert!(light.is_skipped() && light.s.is_clear());
        assert!(light.scissor.is_none() && light.depth_bounds.is_none());
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
    assert!(!light.inside_frustum);
    assert_eq!(ids(&world, &light.s), [0, 1]);
    assert_eq!(light.l.count_ones(..), 5);
    assert_eq!(ids(&world, &light.i), [0]);
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
        assert_eq!(ids(&world, &light.l), expected, "{:?}", light.light.kind);
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
        scene.lights[0].2 = LightSelection { affects, casts_for };
        let (world, _) = run(&scene);
        assert_eq!(ids(&world, &first_light(&world).i), i, "{affects} {casts_for}");
        assert_eq!(ids(&world, &first_light(&world).s), s, "{affects} {casts_for}");
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
    let (scissor, depth) = (light.scissor.unwrap(), light.depth_bounds.unwrap());
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
    let skipped = |light: &FrameLight| light.is_skipped() && light.s.is_clear();
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
fn bad_lights_are_reported_once() {
    let nan = (Light::point(Vec3::ONE, 1.0, f32::NAN), Vec3::ZERO);
    let nowhere = (Light::point(Vec3::ONE, 1.0, 9.0), Vec3::NAN);
    let (mut world, mut schedule) = run(&simple(vec![thing(Vec3::NEG_Z * 9.0, 1.0)], vec![nan, nowhere]));
    let count = |world: &World| {
        let frame = world.resource::<FrameLights>();
        (frame.skipped.len(), frame.newly_skipped.len(), frame.lights.len())
    };
    assert_eq!(count(&world), (2, 2, 0));
    schedule.run(&mut world);
    assert_eq!(count(&world), (2, 0, 0));
    for mut light in world.query::<&mut Light>().iter_mut(&mut world) {
        light.range = 20.0;
    }
    schedule.run(&mut world);
    assert_eq!(count(&world), (1, 0, 1));
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
        for set in [&light.l, &light.i, &light.s] {
            assert_eq!(ids(&world, set), [0, 3]);
        }
        assert!(light.scissor.is_some() && light.depth_bounds.is_some());
    }
}

// ---- statistics ----

/// Mean sizes of the sets of any world whose systems ran, as one line.
fn statistics(name: &str, world: &World) -> String {
    let objects = world.resource::<Objects>();
    let frame = world.resource::<FrameLights>();
    let f = &world.resource::<FrustumSet>().set;
    let shining: Vec<_> = frame.lights.iter().filter(|light| !light.is_skipped()).collect();
    let mean = |size: &dyn Fn(&FrameLight) -> usize| {
        let sum: usize = shining.iter().map(|light| size(light)).sum();
        sum as f64 / shining.len().max(1) as f64
    };
    let kept_by_first_hull = |light: &FrameLight| {
        let touches = |&i: &usize| {
            let outside = light.hull.planes.excludes_aabb(&objects.boxes.get(i));
            if light.inside_frustum {
                f.contains(i)
            } else {
                !outside
            }
        };
        light.l.intersection(&objects.casters).filter(touches).count()
    };
    format!(
        "{name}: {} objects, |F| {}, {} of {} lights shine; mean |L| {:.1}, |I| {:.1}, |S| {:.1} ({:.1} by the first hull alone)",
        objects.len(),
        f.count_ones(..),
        shining.len(),
        frame.lights.len(),
        mean(&|light| light.l.count_ones(..)),
        mean(&|light| light.i.count_ones(..)),
        mean(&|light| light.s.count_ones(..)),
        mean(&kept_by_first_hull),
    )
}

#[test]
fn rooms_need_a_third_of_the_casters_in_range() {
    let scene = rooms(1, 10);
    let (world, _) = run(&scene);
    println!("{}", statistics("rooms 10×10", &world));
    let verdict = judge(&scene, &world, 1);
    assert!(
        verdict.wrong.is_empty() && verdict.looked > 1000,
        "{:?}",
        verdict.wrong
    );
    let frame = world.resource::<FrameLights>();
    let sum = |size: fn(&FrameLight) -> usize| frame.lights.iter().map(size).sum::<usize>();
    assert!(sum(|light| light.s.count_ones(..)) * 3 < sum(|light| light.l.count_ones(..)));
    for seed in 0..3 {
        println!("{}", statistics("random", &run(&random_scene(seed)).0));
    }
}
