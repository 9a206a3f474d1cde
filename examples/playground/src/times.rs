//! Times of the last frames: GPU passes and CPU system sets of each side that is drawn.

use antumbra::schedule::AntumbraSystems;

use crate::compare::Compare;
use crate::document::Side;

/// Frames that are remembered.
pub const FRAMES: usize = 120;

/// Times of a frame of one side, milliseconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// GPU passes by label, in the order of the frame.
    pub passes: Vec<(String, f64)>,
    /// CPU system sets by name, in their order.
    pub sets: Vec<(&'static str, f64)>,
}

impl FrameTimes {
    /// Sum of the passes.
    pub fn gpu(&self) -> f64 {
        self.passes.iter().map(|(_, time)| time).sum()
    }

    /// Sum of the sets.
    pub fn cpu(&self) -> f64 {
        self.sets.iter().map(|(_, time)| time).sum()
    }
}

/// Times of the last frames of both sides.
#[derive(Debug, Default)]
pub struct Times {
    /// The frames of each side, oldest first.
    pub frames: [Vec<FrameTimes>; 2],
}

impl Times {
    /// Remembers the frame that was drawn last.
    pub fn record(&mut self, compare: &Compare) {
        for side in Side::ALL {
            let frames = &mut self.frames[side.index()];
            let Some(stage) = compare.sides[side.index()]
                .as_ref()
                .filter(|_| compare.drawn[side.index()])
            else {
                frames.clear(); // the side is no longer shown
                continue;
            };
            let mut frame = FrameTimes::default();
            // A device that is lost is noticed by whoever draws the next frame.
            for pass in stage.pass_times().unwrap_or_default() {
                match frame.passes.iter_mut().find(|(label, _)| *label == pass.label) {
                    Some((_, time)) => *time += pass.milliseconds,
                    None => frame.passes.push((pass.label, pass.milliseconds)),
                }
            }
            let sets = AntumbraSystems::ALL.iter().zip(stage.set_times().durations);
            frame.sets = sets
                .map(|(set, time)| (set.name(), time.as_secs_f64() * 1e3))
                .collect();
            if frames.len() == FRAMES {
                frames.remove(0);
            }
            frames.push(frame);
        }
    }

    /// Returns the mean of the remembered frames of a side, the costliest pass first.
    pub fn mean(&self, side: Side) -> FrameTimes {
        let frames = &self.frames[side.index()];
        let mut mean = FrameTimes::default();
        let share = 1.0 / frames.len().max(1) as f64;
        for frame in frames {
            for (label, time) in &frame.passes {
                match mean.passes.iter_mut().find(|(known, _)| known == label) {
                    Some((_, sum)) => *sum += time * share,
                    None => mean.passes.push((label.clone(), time * share)),
                }
            }
            for (name, time) in &frame.sets {
                match mean.sets.iter_mut().find(|(known, _)| known == name) {
                    Some((_, sum)) => *sum += time * share,
                    None => mean.sets.push((name, time * share)),
                }
            }
        }
        mean.passes.sort_by(|a, b| b.1.total_cmp(&a.1));
        mean
    }
}
