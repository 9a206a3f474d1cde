//! What a light costs with and without its shadows, and the CPU sets of a steady frame.

use antumbra::prelude::*;
use antumbra::render::{PassTime, RenderError};
use antumbra::schedule::{AntumbraSystems, SetTimes};
use antumbra::techniques::Techniques;
use bevy_ecs::prelude::*;

use super::support::stage::Stage;

/// Frames that a time is the median of.
pub const RUNS: usize = 5;

/// Times of a shot, milliseconds.
#[derive(Clone, Debug, Default)]
pub struct Cost {
    /// CPU by system set, median of [`RUNS`] frames in which nothing moves, all lights on.
    pub cpu_ms: Vec<f64>,
    /// The light's GPU passes with its shadows, the other lights off; `None` without timers.
    pub shadowed_ms: Option<f64>,
    /// The same light without shadows.
    pub unshadowed_ms: Option<f64>,
}

impl Cost {
    /// How many times as long the light takes with its shadows.
    pub fn ratio(&self) -> Option<f64> {
        let (with, without) = (self.shadowed_ms?, self.unshadowed_ms?);
        (without > 0.0).then(|| with / without)
    }
}

/// CPU milliseconds by system set, median of frames in which nothing moves.
pub fn steady_cpu_ms(stage: &mut Stage) -> Vec<f64> {
    let mut by_set = vec![Vec::with_capacity(RUNS); AntumbraSystems::ALL.len()];
    for _ in 0..RUNS {
        stage.schedule.run(&mut stage.world);
        let times = stage.world.resource::<SetTimes>().durations;
        for (values, time) in by_set.iter_mut().zip(times) {
            values.push(time.as_secs_f64() * 1e3);
        }
    }
    by_set.into_iter().filter_map(median).collect()
}

/// Turns all lights off but one; gives what [`restore`] needs.
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

/// Turns lights on again.
pub fn restore(stage: &mut Stage, lights: Vec<(Entity, Light)>) {
    for (entity, light) in lights {
        stage.world.entity_mut(entity).insert(light);
    }
}

/// Times the light's passes with and without its technique, a frame each to warm up.
///
/// # Errors
/// What the device refuses.
pub fn of_light(stage: &mut Stage, light: usize) -> Result<Cost, RenderError> {
    let shadowed_ms = passes_ms(stage, light)?;
    let entity = stage.lights[light];
    let techniques = stage.world.resource::<Techniques>().clone();
    let taken = techniques.take(&mut stage.world.entity_mut(entity));
    let unshadowed_ms = passes_ms(stage, light)?;
    for settings in taken {
        settings.insert(&mut stage.world.entity_mut(entity));
    }
    Ok(Cost {
        cpu_ms: Vec::new(),
        shadowed_ms,
        unshadowed_ms,
    })
}

/// All passes of a light: `light N`, and `light N/…` of its technique.
fn passes_ms(stage: &mut Stage, light: usize) -> Result<Option<f64>, RenderError> {
    stage.time_passes()?;
    let mut times = Vec::with_capacity(RUNS);
    for _ in 0..RUNS {
        let passes = stage.time_passes()?;
        let Some(index) = stage.light_indices()[light] else {
            continue;
        };
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
            times.push(own.iter().sum());
        }
    }
    Ok(median(times))
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
