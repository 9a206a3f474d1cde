//! The sets may keep too many, they never drop what matters: held against brute force over sampled points and rays.

use crate::sets_harness::judge::judge;
use crate::sets_harness::{
    Id, Random, all_sets, random_modelled_scene, random_orthographic_scene, random_scene, rooms, run, simple,
    spawn, thing, transform,
};
use antumbra::geometry::Aabb;
use antumbra::scene::{Camera, Light, LightKind, ShadowCaster, WorldBounds};
use antumbra::sets::{FrameLight, FrameLights, FrustumSet, Objects, SetWork};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::Vec3;
use proptest::prelude::*;

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
    fn nothing_that_shaped_lights_show_is_missing(seed in any::<u64>()) {
        let scene = random_modelled_scene(seed);
        let (world, _) = run(&scene);
        let wrong = judge(&scene, &world, seed).wrong;
        prop_assert!(wrong.is_empty(), "{} missing, first: {}", wrong.len(), wrong[0]);
    }

    #[test]
    fn nothing_seen_by_an_orthographic_camera_is_missing(seed in any::<u64>()) {
        let scene = random_orthographic_scene(seed);
        let (world, _) = run(&scene);
        let wrong = judge(&scene, &world, seed).wrong;
        prop_assert!(wrong.is_empty(), "{} missing, first: {}", wrong.len(), wrong[0]);
    }

    #[test]
    fn incremental_frames_equal_fresh_ones(seed in any::<u64>()) {
        let mut scene = random_scene(seed);
        let (mut world, mut schedule) = run(&scene);
        let mut random = Random::new(seed ^ 77);
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
    for seed in 0..16 {
        let scene = random_scene(seed);
        let (mut world, _) = run(&scene);
        for light in &mut world.resource_mut::<FrameLights>().lights {
            light.sets.s.clear();
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
        ("not in L", |world| {
            each_light(world, |light| light.sets.l.clear())
        }),
        ("not in I", |world| {
            each_light(world, |light| light.sets.i.clear())
        }),
        ("pixel", |world| {
            each_light(world, |light| {
                if let Some(scissor) = &mut light.region.scissor {
                    scissor.width = scissor.width.div_ceil(2);
                }
            })
        }),
        ("depth", |world| {
            each_light(world, |light| {
                if let Some(depth) = &mut light.region.depth_bounds {
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
        let mut random = Random::new(seed + 999);
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
            let outside = light.hulls.view.planes.excludes_aabb(&objects.boxes.get(i));
            if light.hulls.inside_frustum {
                f.contains(i)
            } else {
                !outside
            }
        };
        light
            .sets
            .l
            .intersection(&objects.casters)
            .filter(touches)
            .count()
    };
    format!(
        "{name}: {} objects, |F| {}, {} of {} lights shine; mean |L| {:.1}, |I| {:.1}, |S| {:.1} ({:.1} by the first hull alone)",
        objects.len(),
        f.count_ones(..),
        shining.len(),
        frame.lights.len(),
        mean(&|light| light.sets.l.count_ones(..)),
        mean(&|light| light.sets.i.count_ones(..)),
        mean(&|light| light.sets.s.count_ones(..)),
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
    assert!(sum(|light| light.sets.s.count_ones(..)) * 3 < sum(|light| light.sets.l.count_ones(..)));
    for seed in 0..3 {
        println!("{}", statistics("random", &run(&random_scene(seed)).0));
    }
}

/// A cube behind an orthographic camera that shows what is behind it: every kind of light reaches it.
#[test]
fn lights_at_negative_view_depth_shine() {
    let mut scene = simple(
        vec![thing(Vec3::new(0.0, 0.0, 5.0), 1.0)],
        vec![
            (directional(), Vec3::ZERO),
            (
                Light {
                    kind: LightKind::Point,
                    ..directional()
                },
                Vec3::new(0.0, 0.5, 8.0),
            ),
            (
                Light {
                    kind: LightKind::Spot {
                        inner_angle: 0.3,
                        outer_angle: 0.6,
                    },
                    ..directional()
                },
                Vec3::new(0.0, 0.5, 8.0),
            ),
        ],
    );
    scene.camera = Camera::orthographic(4.0, -10.0, 0.0, 1.0);
    let (world, _) = run(&scene);
    for light in &world.resource::<FrameLights>().lights {
        assert!(!light.is_skipped(), "{:?}", light.light);
        let bounds = light.region.depth_bounds.unwrap();
        assert!(bounds.near <= -6.0 && bounds.far >= -4.0, "{bounds:?}");
    }
    assert_eq!(world.resource::<FrameLights>().lights.len(), 3);
    // The judge would see such a loss.
    let verdict = judge(&scene, &world, 1);
    assert!(verdict.wrong.is_empty() && verdict.looked > 20);
    let mut world = world;
    each_light(&mut world, |light| light.sets.i.clear());
    assert!(judge(&scene, &world, 1).wrong.len() > 20);
}

fn directional() -> Light {
    Light {
        kind: LightKind::Directional,
        color: Vec3::ONE,
        intensity: 1.0,
        range: f32::INFINITY,
    }
}
