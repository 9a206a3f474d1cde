//! Shows that the cost follows the number of pairs of a light and an object within its range, not objects × lights.

use std::time::Instant;

use antumbra::scene::Light;
use antumbra::sets::{FrameLights, SetWork};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;

use crate::field;

/// Prints the table.
pub fn run(short: bool) {
    println!(
        "\nwhat a frame costs on one thread, µs: at rest, all objects moving, all lights moving; the cost of"
    );
    println!("lights follows the pairs that they touch (within range), not objects × lights");
    println!(
        "{:>8} {:>6} {:>6} {:>10} {:>10} {:>10} {:>11} {:>11} {:>11} {:>9} {:>11}",
        "objects",
        "lights",
        "range",
        "pairs",
        "touched",
        "rest",
        "rest/light",
        "objects",
        "lights",
        "per light",
        "ns/touched"
    );
    let frames = if short { 4 } else { 12 };
    let objects: &[usize] = if short {
        &[10_000]
    } else {
        &[10_000, 100_000, 400_000]
    };
    let lights: &[usize] = if short { &[64] } else { &[8, 64, 256] };
    for &objects in objects {
        // Cost of finding out that nothing changed, without any light.
        let idle = Measured::of(objects, 0, 20.0, frames).at_rest;
        for &lights in lights {
            for range in [5.0, 20.0, 60.0] {
                let measured = Measured::of(objects, lights, range, frames);
                let Measured {
                    touched,
                    at_rest,
                    objects_move,
                    lights_move,
                } = measured;
                let per_light = (at_rest - idle).max(0.0) / lights as f64;
                println!(
                    "{objects:>8} {lights:>6} {range:>6} {:>10} {touched:>10} {at_rest:>10.1} {per_light:>11.3} {objects_move:>11.1} {lights_move:>11.1} {:>9.2} {:>11.2}",
                    objects * lights,
                    lights_move / lights as f64,
                    lights_move * 1e3 / touched.max(1) as f64,
                );
            }
        }
    }
}

/// Frame times in microseconds, each the least of several.
struct Measured {
    /// Number of pairs of a light and an object in its range.
    touched: usize,
    at_rest: f64,
    objects_move: f64,
    lights_move: f64,
}

impl Measured {
    fn of(objects: usize, lights: usize, range: f32, frames: usize) -> Self {
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
        let frame = world.resource::<FrameLights>();
        let touched = frame.lights.iter().map(|light| light.sets.l.count_ones(..)).sum();
        let work = *world.resource::<SetWork>();
        let at_rest = time(&mut world, &mut |_| ());
        assert_eq!(
            work,
            *world.resource::<SetWork>(),
            "a frame at rest computed something"
        );
        let mut step = 0.01;
        let objects_move = time(&mut world, &mut |world| {
            step = -step;
            field::shake(world, 1, step);
        });
        let mut places = world.query_filtered::<&mut GlobalTransform, With<Light>>();
        let lights_move = time(&mut world, &mut |world| {
            step = -step;
            for mut place in places.iter_mut(world) {
                let mut moved = place.affine();
                moved.translation.x += step;
                *place = moved.into();
            }
        });
        Self {
            touched,
            at_rest,
            objects_move,
            lights_move,
        }
    }
}
