//! The smallest history that still goes wrong.

use std::time::{Duration, Instant};

use antumbra::prelude::*;
use antumbra::sets::OcclusionSettings;
use bevy_transform::prelude::Transform;

use super::spec::{Lamp, Spec, Thing};
use super::world::Step;

/// How long a history is shrunk at most.
const SHRINKING: Duration = Duration::from_secs(60);

/// Takes away what a failure does not need. `fails` tells whether a history still fails.
pub fn shrink(mut history: Vec<Step>, fails: impl Fn(&[Step]) -> bool) -> Vec<Step> {
    let end = Instant::now() + SHRINKING;
    let fails = |history: &[Step]| Instant::now() < end && fails(history);
    loop {
        let mut length = history.len() / 2;
        while length > 1 {
            let mut at = 0;
            while at + length < history.len() {
                let mut fewer = history.clone();
                fewer.drain(at..at + length);
                if fails(&fewer) {
                    history = fewer;
                } else {
                    at += length;
                }
            }
            length /= 2;
        }
        let mut smaller = false;
        let mut at = 0;
        while at + 1 < history.len() {
            let mut fewer = history.clone();
            fewer.remove(at);
            if fails(&fewer) {
                history = fewer;
                smaller = true;
            } else {
                at += 1;
            }
        }
        let mut tried = |change: &dyn Fn(&mut Step, &Step)| {
            let last = history[history.len() - 1].clone();
            let mut simpler = history.clone();
            simpler.iter_mut().for_each(|step| change(step, &last));
            let differs = simpler.iter().zip(&history).any(|(a, b)| {
                a.spec != b.spec || a.blinks != b.blinks || a.in_place != b.in_place || a.draws != b.draws
            });
            if differs && fails(&simpler) {
                history = simpler;
                smaller = true;
            }
        };
        for change in step_changes() {
            tried(&|step, _| change(step));
        }
        let mut ids: Vec<u32> = Vec::new();
        for step in &history.clone() {
            ids.extend(step.spec.things.iter().map(|thing| thing.id));
            ids.extend(step.spec.lamps.iter().map(|lamp| lamp.id));
        }
        ids.sort_unstable();
        ids.dedup();
        let mut tried = |change: &dyn Fn(&mut Step, &Step)| {
            let last = history[history.len() - 1].clone();
            let mut simpler = history.clone();
            simpler.iter_mut().for_each(|step| change(step, &last));
            let differs = simpler.iter().zip(&history).any(|(a, b)| a.spec != b.spec);
            if differs && fails(&simpler) {
                history = simpler;
                smaller = true;
            }
        };
        for id in ids {
            tried(&|step, _| {
                step.spec.things.retain(|thing| thing.id != id);
                step.spec.lamps.retain(|lamp| lamp.id != id);
            });
            tried(&|step, last| settle(&mut step.spec, &last.spec, id));
            for change in thing_changes() {
                tried(&|step, _| {
                    step.spec
                        .things
                        .iter_mut()
                        .filter(|t| t.id == id)
                        .for_each(change)
                });
            }
            for change in lamp_changes() {
                tried(&|step, _| step.spec.lamps.iter_mut().filter(|l| l.id == id).for_each(change));
            }
        }
        if !smaller {
            return history;
        }
    }
}

/// Makes an entity be all the time what it is at the end.
fn settle(spec: &mut Spec, last: &Spec, id: u32) {
    if let Some(end) = last.things.iter().find(|thing| thing.id == id) {
        match spec.things.iter_mut().find(|thing| thing.id == id) {
            Some(thing) => *thing = end.clone(),
            None => spec.things.push(end.clone()),
        }
    }
    if let Some(end) = last.lamps.iter().find(|lamp| lamp.id == id) {
        match spec.lamps.iter_mut().find(|lamp| lamp.id == id) {
            Some(lamp) => *lamp = end.clone(),
            None => spec.lamps.push(end.clone()),
        }
    }
}

fn step_changes() -> [fn(&mut Step); 17] {
    [
        |step| step.blinks.clear(),
        |step| step.in_place = true,
        |step| step.in_place = false,
        |step| step.draws = true,
        |step| step.spec.portal = None,
        |step| step.spec.cells = [None; 2],
        |step| step.spec.cells[1] = None,
        |step| step.spec.occlusion = OcclusionSettings::NONE,
        |step| step.spec.occlusion = super::changes::usual(),
        |step| step.spec.culling = FaceCulling::default(),
        |step| step.spec.culled = CulledCasters::default(),
        |step| step.spec.pivots = [Transform::IDENTITY; 2],
        |step| step.spec.ignores_scale = None,
        |step| step.spec.size = glam::UVec2::new(48, 27),
        |step| step.spec.camera = Some(Camera::default()),
        |step| (step.spec.scissor, step.spec.depth_bounds) = (true, true),
        |step| step.spec.ambient = glam::Vec3::splat(0.05),
    ]
}

fn thing_changes() -> [fn(&mut Thing); 13] {
    [
        |thing| thing.parent = None,
        |thing| thing.place = Transform::IDENTITY,
        |thing| thing.materials = Thing::new(0, 0).materials,
        |thing| thing.caster = Some(ShadowCaster),
        |thing| thing.receiver = Some(ShadowReceiver),
        |thing| thing.layers = None,
        |thing| thing.occluder = None,
        |thing| thing.morph = None,
        |thing| thing.skin = None,
        |thing| thing.blurred = None,
        |thing| thing.extra = None,
        |thing| thing.weights = None,
        |thing| thing.cells = None,
    ]
}

fn lamp_changes() -> [fn(&mut Lamp); 12] {
    [
        |lamp| lamp.parent = None,
        |lamp| lamp.selection = None,
        |lamp| lamp.shape = None,
        |lamp| lamp.distance = None,
        |lamp| lamp.weights = None,
        |lamp| lamp.tint = None,
        |lamp| lamp.origin = None,
        |lamp| lamp.softness = None,
        |lamp| lamp.barn_map = None,
        |lamp| lamp.cookie = None,
        |lamp| lamp.profile = None,
        |lamp| lamp.place = Lamp::new(0).place,
    ]
}

/// Each step, by the lines in which it differs from the one before.
pub fn describe(history: &[Step]) -> String {
    let mut text = String::new();
    let mut before: Vec<String> = Vec::new();
    for (at, step) in history.iter().enumerate() {
        text += &format!(
            "== step {at}, in place: {}, draws: {}, blinks: {:?}\n",
            step.in_place, step.draws, step.blinks
        );
        let lines: Vec<String> = lines(&step.spec);
        for line in lines.iter().filter(|line| !before.contains(line)) {
            text += &format!("+ {line}\n");
        }
        for line in before.iter().filter(|line| !lines.contains(line)) {
            text += &format!("- {line}\n");
        }
        before = lines;
    }
    text
}

/// One line for each entity and setting, without what is absent.
fn lines(spec: &Spec) -> Vec<String> {
    let usual = format!(", materials: {:?}", Thing::new(0, 0).materials);
    let short = |text: String| {
        let text = text.replace(&usual, "");
        let parts = text.split(", ").filter(|part| !part.ends_with(": None"));
        parts.collect::<Vec<_>>().join(", ")
    };
    let mut lines: Vec<String> = spec
        .things
        .iter()
        .map(|thing| short(format!("{thing:?}")))
        .collect();
    lines.extend(spec.lamps.iter().map(|lamp| short(format!("{lamp:?}"))));
    lines.push(format!("pivots {:?}", spec.pivots));
    let view = (spec.camera, spec.eye, spec.ignores_scale, spec.size);
    lines.push(format!("view {view:?}"));
    lines.push(format!(
        "{:?} {:?} {:?}",
        spec.culling, spec.culled, spec.occlusion
    ));
    lines.push(format!(
        "ambient, scissor, bounds {} {} {}",
        spec.ambient, spec.scissor, spec.depth_bounds
    ));
    lines.push(format!("cells {:?} portal {:?}", spec.cells, spec.portal));
    lines
}
