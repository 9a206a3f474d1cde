//! Comparison with the obvious loop that has the same result. The loop reads the bounds from the world into an array
//! of structures, tests each with scalars, keeps a `Vec` of indices for each set and projects the boxes of I for the
//! scissor. It does so every frame, so its time is the same for both kinds of frame.
//!
//! Both are asserted to agree before they are timed. Rounding may keep more objects in our F, L and I. Our S has
//! fewer, because it also tests receivers. Both run on one thread.

use std::hint::black_box;
use std::time::{Duration, Instant};

use antumbra::geometry::{Aabb, LightHull};
use antumbra::scene::{Camera, Light, SceneMaterials, ShadowCaster, ShadowReceiver, WorldBounds};
use antumbra::sets::{
    FrameLights, FrustumSet, LightVolume, Objects, Projector, ScreenBounds, View, ViewportSize, collect_sets,
    init_set_resources,
};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{UVec2, Vec3};

struct Object {
    aabb: Aabb,
}

/// Computes L, I and S of a light by the obvious loop.
#[derive(Default)]
struct NaiveSets {
    l: Vec<usize>,
    i: Vec<usize>,
    s: Vec<usize>,
    screen: Option<ScreenBounds>,
}

/// Prints the table.
pub fn run(short: bool) {
    let budget = Duration::from_millis(if short { 60 } else { 600 });
    println!(
        "{:>7} {:>6}  {:>8} {:>12} {:>12} {:>12} {:>7}",
        "objects", "lights", "frame", "ours µs", "ns/pair", "naive ns/pair", "ratio"
    );
    for objects in [1_000, 10_000] {
        for lights in [1, 8, 64] {
            compare(objects, lights, budget);
        }
    }
}

fn compare(objects: usize, lights: usize, budget: Duration) {
    let (mut world, mut schedule) = scene(objects, lights);
    schedule.run(&mut world);
    // In the order of the dense index, so that the sets can be compared.
    let bounds = |&entity: &Entity| {
        world
            .get::<WorldBounds>(entity)
            .map_or(Aabb::EMPTY, |bounds| bounds.0)
    };
    let entities = &world.resource::<Objects>().entities;
    let list: Vec<Object> = entities
        .iter()
        .map(|entity| Object { aabb: bounds(entity) })
        .collect();
    let naive_sets = naive(&list, &world);
    assert_agrees(&naive_sets, &world);
    let mut read = world.query::<&WorldBounds>();
    let naive_time = time(budget, || {
        let list: Vec<Object> = read
            .iter(&world)
            .map(|bounds| Object { aabb: bounds.0 })
            .collect();
        black_box(naive(black_box(&list), &world));
    });
    let rest = time(budget, || schedule.run(&mut world));
    let mut bounds = world.query::<&mut WorldBounds>();
    let mut step = 0.001;
    let mut move_all = |world: &mut World| {
        step = -step;
        for mut bounds in bounds.iter_mut(world) {
            bounds.0.min.x += step;
            bounds.0.max.x += step;
        }
    };
    // A game moves the objects, so that time is measured alone and subtracted.
    let moving = time(budget, || move_all(&mut world));
    let moved = time(budget, || {
        move_all(&mut world);
        schedule.run(&mut world);
    });
    let moved = (moved - moving).max(0.0);
    let pairs = (objects * lights) as f64;
    for (name, ours) in [("at rest", rest), ("moving", moved)] {
        println!(
            "{objects:>7} {lights:>6}  {name:>8} {:>12.1} {:>12.3} {:>12.3} {:>7.1}",
            ours * 1e6,
            ours * 1e9 / pairs,
            naive_time * 1e9 / pairs,
            naive_time / ours,
        );
    }
}

/// Returns the mean time of a warm call, seconds.
fn time(budget: Duration, mut call: impl FnMut()) -> f64 {
    call();
    let start = Instant::now();
    let mut calls = 0u32;
    while start.elapsed() < budget || calls < 3 {
        call();
        calls += 1;
    }
    start.elapsed().as_secs_f64() / f64::from(calls)
}

fn scene(objects: usize, lights: usize) -> (World, Schedule) {
    let mut state = 1u64;
    let mut unit = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    let mut world = World::new();
    init_set_resources(&mut world);
    world.insert_resource(ViewportSize(UVec2::new(1920, 1080)));
    world.spawn((Camera::default(), GlobalTransform::from_xyz(0.0, 3.0, 60.0)));
    for _ in 0..objects {
        let center = Vec3::new(unit() - 0.5, unit() * 0.1, unit() - 0.5) * 120.0;
        let half = Vec3::new(unit(), unit(), unit()) + 0.1;
        world.spawn((
            WorldBounds(Aabb {
                min: center - half,
                max: center + half,
            }),
            ShadowCaster,
            ShadowReceiver,
            SceneMaterials(Default::default()),
        ));
    }
    for _ in 0..lights {
        let at = Vec3::new(unit() - 0.5, 0.05 + unit() * 0.05, unit() - 0.5) * 120.0;
        let place = GlobalTransform::from(Transform::from_translation(at));
        world.spawn((Light::point(Vec3::ONE, 100.0, 15.0), place));
    }
    let mut schedule = Schedule::default();
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.add_systems(collect_sets());
    (world, schedule)
}

fn naive(objects: &[Object], world: &World) -> (Vec<usize>, Vec<NaiveSets>) {
    let Some(view) = &world.resource::<View>().data else {
        return Default::default();
    };
    let projector = Projector::new(view);
    let visible: Vec<bool> = objects
        .iter()
        .map(|object| !view.frustum.planes.excludes_aabb(&object.aabb))
        .collect();
    let lights = world.resource::<FrameLights>().lights.iter().map(|light| {
        let mut sets = NaiveSets::default();
        let hull = LightHull::of_frustum(&view.frustum, &light.emitter);
        let LightVolume::Ball(ball) = light.volume else {
            return sets;
        };
        for (i, object) in objects.iter().enumerate() {
            if !ball.intersects_aabb(&object.aabb) {
                continue;
            }
            sets.l.push(i);
            if visible[i] {
                sets.i.push(i);
                let (center, half) = (
                    object.aabb.center().as_dvec3(),
                    object.aabb.half_size().as_dvec3(),
                );
                let bounds = projector.bounds_of_box(center, half);
                sets.screen = Some(sets.screen.map_or(bounds, |screen| screen.union(bounds)));
            }
            let reaches = if hull.inside {
                visible[i]
            } else {
                !hull.planes.excludes_aabb(&object.aabb)
            };
            if reaches {
                sets.s.push(i);
            }
        }
        if sets.i.is_empty() {
            sets.s.clear();
        }
        sets
    });
    let lights = lights.collect();
    ((0..objects.len()).filter(|&i| visible[i]).collect(), lights)
}

fn assert_agrees((f, lights): &(Vec<usize>, Vec<NaiveSets>), world: &World) {
    let ours = &world.resource::<FrustumSet>().set;
    let more = |name: &str, naive: &[usize], ours: &fixedbitset::FixedBitSet| {
        assert!(naive.iter().all(|&i| ours.contains(i)), "{name} lacks an object");
        let extra = ours.count_ones(..) - naive.len();
        assert!(
            extra * 100 <= naive.len() + 100,
            "{name} has {extra} objects more than {}",
            naive.len()
        );
    };
    more("F", f, ours);
    for (light, naive) in world.resource::<FrameLights>().lights.iter().zip(lights) {
        more("L", &naive.l, &light.sets.l);
        if !light.is_skipped() {
            more("I", &naive.i, &light.sets.i);
        }
        // Our S is smaller than the naive one, because it also tests receivers.
        assert!(light.sets.s.count_ones(..) <= naive.s.len() + 1);
    }
}
