//! Costs of a light with and without its shadows, and of the CPU sets in a steady frame.

use antumbra::prelude::*;
use antumbra::render::{PassTime, RenderError};
use antumbra::schedule::{AntumbraSystems, SetTimes};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::support::stage::Stage;

/// Number of frames of which a time is the median.
pub const RUNS: usize = 3;

/// Distance by which a moving light moves from frame to frame, metres, and angle by which it turns, radians: too small to
/// be seen, and enough for everything that depends on the light to be made again.
const STEP: f32 = 1e-4;

/// Times of a shot, milliseconds.
#[derive(Clone, Debug, Default)]
pub struct Cost {
    /// CPU times by system set with all lights on: medians of [`RUNS`] frames in which nothing moves.
    pub cpu_ms: Vec<f64>,
    /// GPU time of the light's passes with its shadows and with the other lights off; `None` without timers.
    pub shadowed_ms: Option<f64>,
    /// GPU time of the light's passes while it moves in every frame; `None` without timers.
    pub moving_ms: Option<f64>,
    /// CPU time of all system sets while the light moves in every frame.
    pub moving_cpu_ms: Option<f64>,
    /// GPU time of the light's passes without its shadows; `None` without timers.
    pub unshadowed_ms: Option<f64>,
}

impl Cost {
    /// Returns the time of the light with its shadows divided by the time without, in frames in which nothing moves.
    pub fn ratio(&self) -> Option<f64> {
        quotient(self.shadowed_ms?, self.unshadowed_ms?)
    }

    /// Returns the time of the light with its shadows while it moves, divided by the time without shadows.
    pub fn moving_ratio(&self) -> Option<f64> {
        quotient(self.moving_ms?, self.unshadowed_ms?)
    }
}

fn quotient(with: f64, without: f64) -> Option<f64> {
    (without > 0.0).then(|| with / without)
}

/// Returns CPU milliseconds by system set: medians of frames in which nothing moves.
fn steady_cpu_ms(stage: &mut Stage) -> Vec<f64> {
    stage.run();
    let mut by_set = vec![Vec::with_capacity(RUNS); AntumbraSystems::ALL.len()];
    for _ in 0..RUNS {
        stage.run();
        let times = stage.world.resource::<SetTimes>().durations;
        for (values, time) in by_set.iter_mut().zip(times) {
            values.push(time.as_secs_f64() * 1e3);
        }
    }
    by_set.into_iter().filter_map(median).collect()
}

/// Turns off all lights except one. Returns what [`restore`] needs.
pub fn isolate(stage: &mut Stage, light: usize) -> Vec<(Entity, Light)> {
    let entities: Vec<Entity> = stage.lights.clone();
    let others = entities
        .into_iter()
        .enumerate()
        .filter(|(index, _)| *index != light);
    others
        .filter_map(|(_, entity)| Some((entity, stage.world.entity_mut(entity).take::<Light>()?)))
        .collect()
}

/// Turns on the lights that [`isolate`] turned off.
pub fn restore(stage: &mut Stage, lights: Vec<(Entity, Light)>) {
    for (entity, light) in lights {
        stage.world.entity_mut(entity).insert(light);
    }
}

/// Times the passes of a light that has no technique, with the other lights off. `None` without timers.
///
/// # Errors
/// Something that the device refuses.
pub fn unshadowed_ms(stage: &mut Stage, light: usize) -> Result<Option<f64>, RenderError> {
    let others = isolate(stage, light);
    let (milliseconds, _) = passes_ms(stage, light, false)?;
    restore(stage, others);
    Ok(milliseconds)
}

/// Times the system sets with all lights, and the passes of one light with its technique, at rest and on the move, with the
/// other lights off. `unshadowed_ms` is what its passes take without its technique.
///
/// # Errors
/// Something that the device refuses.
pub fn of_light(stage: &mut Stage, light: usize, unshadowed_ms: Option<f64>) -> Result<Cost, RenderError> {
    let cpu_ms = steady_cpu_ms(stage);
    let others = isolate(stage, light);
    let (shadowed_ms, _) = passes_ms(stage, light, false)?;
    let entity = stage.lights[light];
    let place = stage.world.get::<Transform>(entity).copied();
    let (moving_ms, moving_cpu_ms) = passes_ms(stage, light, true)?;
    if let Some(place) = place {
        stage.world.entity_mut(entity).insert(place);
    }
    restore(stage, others);
    Ok(Cost {
        cpu_ms,
        shadowed_ms,
        moving_ms,
        moving_cpu_ms,
        unshadowed_ms,
    })
}

/// Times all passes of a light: `light N`, and those of its technique, `light N/…`. Also times all system sets on the CPU. Both
/// are medians of [`RUNS`] frames; at rest, after one that warms up.
fn passes_ms(
    stage: &mut Stage,
    light: usize,
    moves: bool,
) -> Result<(Option<f64>, Option<f64>), RenderError> {
    let mut gpu = Vec::with_capacity(RUNS);
    let mut cpu = Vec::with_capacity(RUNS);
    let warm_up = usize::from(!moves);
    for run in 0..warm_up + RUNS {
        if moves {
            nudge(stage, light, run);
        }
        let passes = stage.time_passes()?;
        let Some(index) = stage.light_indices()[light] else {
            continue;
        };
        if run < warm_up {
            continue;
        }
        let label = format!("light {index}");
        let is_own = |pass: &&PassTime| {
            let rest = pass.label.strip_prefix(&label);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        let own: Vec<f64> = passes
            .iter()
            .filter(is_own)
            .map(|pass| pass.milliseconds)
            .collect();
        if !own.is_empty() {
            gpu.push(own.iter().sum());
        }
        let sets = stage.world.resource::<SetTimes>().durations;
        cpu.push(sets.iter().map(|time| time.as_secs_f64() * 1e3).sum());
    }
    Ok((median(gpu), median(cpu)))
}

/// Moves and turns a light by [`STEP`], there and back in turn.
fn nudge(stage: &mut Stage, light: usize, run: usize) {
    let step = if run.is_multiple_of(2) { STEP } else { -STEP };
    if let Some(mut place) = stage.world.get_mut::<Transform>(stage.lights[light]) {
        place.translation += Vec3::splat(step);
        place.rotate_local_x(step);
    }
}

/// Returns the middle of some values, or the upper one of two.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
