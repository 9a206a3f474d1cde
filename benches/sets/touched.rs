//! What the cost follows: pairs of a light and an object within its range, not objects × lights.

use std::time::Instant;

use antumbra::sets::{FrameLights, SetWork};
use bevy_ecs::prelude::*;

use crate::field;

/// Prints the table.
pub fn run(short: bool) {
    println!(
        "\ncost against what the lights touch, this thread alone: static, all objects moving, all lights moving"
    );
    println!(
        "{:>8} {:>6} {:>6} {:>10} {:>10} {:>11} {:>11} {:>11} {:>11} {:>12}",
        "objects",
        "lights",
        "range",
        "pairs",
        "touched",
        "static µs",
        "objects µs",
        "lights µs",
        "µs/light",
        "ns/touched"
    );
    if std::env::var("ONE").is_ok() {
        measure(100_000, 64, 20.0, 300);
        return;
    }
    let objects: &[usize] = if short {
        &[10_000, 100_000]
    } else {
        &[10_000, 100_000, 400_000]
    };
    let lights: &[usize] = if short { &[64] } else { &[8, 64, 256] };
    for &objects in objects {
        for &lights in lights {
            for range in [5.0, 20.0, 60.0] {
                measure(objects, lights, range, if short { 4 } else { 12 });
            }
        }
    }
}

fn measure(objects: usize, lights: usize, range: f32, frames: usize) {
    let mut world = field::world(objects, lights, range);
    let mut schedule = field::schedule();
    let mut time = |world: &mut World, prepare: &mut dyn FnMut(&mut World)| {
        let mut least = f64::INFINITY;
        for _ in 0..frames {
            prepare(world);
            let start = Instant::now();
            schedule.run(world);
            least = least.min(start.elapsed().as_secs_f64() * 1e6);
        }
        least
    };
    time(&mut world, &mut |_| ());
    let touched = |world: &World| -> usize {
        let frame = world.resource::<FrameLights>();
        frame.lights.iter().map(|light| light.l.count_ones(..)).sum()
    };
    let pairs = touched(&world);
    let work = *world.resource::<SetWork>();
    let at_rest = time(&mut world, &mut |_| ());
    assert_eq!(
        work,
        *world.resource::<SetWork>(),
        "a frame at rest computed something"
    );
    let mut step = 0.01;
    let all_move = time(&mut world, &mut |world| {
        step = -step;
        field::shake(world, 1, step);
    });
    let mut lights_query =
        world.query_filtered::<&mut bevy_transform::prelude::GlobalTransform, With<antumbra::scene::Light>>();
    let lights_move = time(&mut world, &mut |world| {
        step = -step;
        for mut place in lights_query.iter_mut(world) {
            let mut moved = place.affine();
            moved.translation.x += step;
            *place = moved.into();
        }
    });
    println!(
        "{objects:>8} {lights:>6} {range:>6} {:>10} {pairs:>10} {at_rest:>11.1} {all_move:>11.1} {lights_move:>11.1} {:>11.2} {:>12.2}",
        objects * lights,
        lights_move / lights as f64,
        lights_move * 1e3 / pairs.max(1) as f64,
    );
}
