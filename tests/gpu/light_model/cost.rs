//! What each part of the light model costs, beside the same lights without it. The figures are printed:
//!
//! ```sh
//! cargo test --features bevy,gltf,reference,profile --test gpu light_model::cost -- --ignored --nocapture
//! ```

use std::time::Instant;

use antumbra::prelude::*;
use antumbra::scene::{BarnMap, CookieImage, LightDistance, LightShape, LightWeights, ShadowTint};
use bevy_ecs::world::EntityWorldMut;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use super::{floor_and_ball, stage};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

const ROUNDS: usize = 9;

/// A part of the light model by name.
type Part = (&'static str, fn(&mut EntityWorldMut));

fn shape() -> LightShape {
    LightShape {
        width: 0.6,
        height: 0.6,
        width_edge: 0.3,
        height_edge: 0.3,
        round: 0.5,
    }
}

fn cookie(light: &mut EntityWorldMut) {
    let texels = (0..64 * 64).map(|at| Vec3::splat(if (at / 8 + at / 512) % 2 == 0 { 1.0 } else { 0.3 }));
    let image = CookieImage::from_linear("checkers", 64, 64, texels.collect()).expect("a picture");
    light.insert(Cookie::around(image));
}

fn profile(light: &mut EntityWorldMut) {
    let text = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 10\n0 45 180\n0\n5 4 3\n";
    light.insert(LightProfile::from_ies(text).expect("the file is read"));
}

const PARTS: [Part; 10] = [
    ("nothing", |_| {}),
    ("shape", |light| {
        light.insert(shape());
    }),
    ("shape, barn map", |light| {
        light.insert((shape(), BarnMap::default()));
    }),
    ("distance", |light| {
        light.insert(LightDistance {
            far: 6.0,
            far_edge: 2.0,
            ..LightDistance::default()
        });
    }),
    ("weights", |light| {
        light.insert(LightWeights {
            specular: 0.5,
            ..LightWeights::default()
        });
    }),
    ("tint", |light| {
        light.insert(ShadowTint {
            color: Vec3::new(0.0, 0.0, 0.2),
            darkness: 0.8,
        });
    }),
    ("cookie", cookie),
    ("profile", profile),
    ("cookie, profile", |light| {
        cookie(light);
        profile(light);
    }),
    ("all of it", |light| {
        cookie(light);
        profile(light);
        light.insert((
            shape(),
            LightDistance {
                far: 6.0,
                far_edge: 2.0,
                ..LightDistance::default()
            },
            ShadowTint {
                color: Vec3::new(0.0, 0.0, 0.2),
                darkness: 0.8,
            },
        ));
    }),
];

fn lit(count: usize, size: UVec2, part: fn(&mut EntityWorldMut)) -> Stage {
    let mut stage = stage(&strict_context());
    stage.world.insert_resource(ViewportSize(size));
    floor_and_ball(&mut stage);
    for index in 0..count {
        let angle = index as f32 * 2.4;
        let at =
            Transform::from_xyz(1.5 * angle.cos(), 3.0, 1.5 * angle.sin()).looking_at(Vec3::ZERO, Vec3::X);
        let light = Light::point(Vec3::ONE, 20.0, 12.0);
        let entity = stage.spawn_light(light, at, Some(StencilVolume::default()));
        part(&mut stage.world.entity_mut(entity));
    }
    for _ in 0..3 {
        stage.draw().expect("the frame renders");
    }
    stage
}

/// Time of a frame from its systems to the end of the device's work, milliseconds.
fn frame(stage: &mut Stage) -> f64 {
    let begin = Instant::now();
    stage.draw().expect("the frame renders");
    let device = &stage.world.resource::<Renderer>().context().device;
    device
        .poll(wgpu::PollType::wait_indefinitely())
        .expect("the device works");
    begin.elapsed().as_secs_f64() * 1e3
}

#[test]
#[ignore = "prints times"]
fn frames_with_parts_of_the_light_model_by_hand() {
    let size = UVec2::new(640, 360);
    println!(
        "{}: ms a frame of {size}, and the ratio to lights without a model",
        strict_context().adapter
    );
    for count in [1, 9] {
        let mut stages: Vec<_> = PARTS.iter().map(|(_, part)| lit(count, size, *part)).collect();
        // They take turns, so that drift affects all of them. The fastest round is the one that nothing disturbed.
        let mut best = [f64::INFINITY; PARTS.len()];
        for _ in 0..ROUNDS {
            for (best, stage) in best.iter_mut().zip(&mut stages) {
                *best = best.min(frame(stage));
            }
        }
        for ((name, _), time) in PARTS.iter().zip(best) {
            println!("{count} lights, {name:16} {time:8.2} ms {:6.2}", time / best[0]);
        }
    }
}
