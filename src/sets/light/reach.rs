//! Finds the objects within the volume of each light, occluded from it or not.

use bevy_ecs::prelude::*;

use super::clearance::{LightClearance, Surroundings};
use super::frame_light::{FrameLight, LightScratch, Seen};
use super::frame_lights::FrameLights;
use crate::scene::tasks;
use crate::sets::index::objects::{Objects, resize};
use crate::sets::view::frame_view::View;
use crate::sets::view::visible::VisibleSet;
use crate::sets::work::SetWork;

/// Number of (word, light) pairs to process from which it is worth waking threads.
const PARALLEL: usize = 4096;

/// Computes [`LightSets::reach`](super::frame_light::LightSets::reach) of every light: as a whole if the light or the layout changed, otherwise in
/// words in which something moved. Also computes each light's clearance
/// ([`LightClearance`]), which depends on what it reaches. Lights are independent and are computed on all threads.
///
/// Set: `CollectSets`, after `collect_frame_lights` and `collect_visible_set`. Conservative. Cost: for each
/// light the blocks of 4096 objects, then what the light touches; nothing in a frame at rest. Point lights
/// test against a ball and need no projection.
/// Source: McGuire 2004, GPU Gems ch. 9, §9.5.2: boxes against the range's ball or the cone; O'Rorke 2004,
/// ch. 15, §15.4.2: no projection.
pub fn collect_light_sets(
    mut frame: ResMut<FrameLights>,
    mut work: ResMut<SetWork>,
    objects: Res<Objects>,
    view: Res<View>,
    visible: Res<VisibleSet>,
    clearance: Res<LightClearance>,
) {
    let now = Seen {
        layout: objects.layout_generation,
        flags: objects.flags_generation,
        view: view.generation,
        visible: visible.generation,
    };
    let any_moved = objects.any_moved();
    let lights = &mut frame.lights;
    let busy = lights
        .iter()
        .filter(|light| any_moved || light.moved || light.progress.seen != Some(now));
    let pairs = busy.count() * objects.boxes.words();
    each_light(lights, &mut work, pairs, |light| {
        collect_reach(light, &objects, now, any_moved, *clearance)
    });
}

/// Calls `collect` for every light, on all threads if there is enough to do, and sums up the work that was
/// done. `pairs` is the number of words that need processing, summed over all lights.
pub(in crate::sets) fn each_light(
    lights: &mut [FrameLight],
    work: &mut SetWork,
    pairs: usize,
    collect: impl Fn(&mut FrameLight) + Sync,
) {
    let parallel = pairs > PARALLEL && lights.len() > 1;
    // Chunks are small, because neighbouring lights may be the costly ones.
    let chunk = if parallel {
        lights.len().div_ceil(32)
    } else {
        usize::MAX
    };
    tasks::for_each(lights.chunks_mut(chunk), parallel, |lights| {
        lights.iter_mut().for_each(&collect)
    });
    for light in lights {
        let done = std::mem::take(&mut light.progress.work);
        work.light_words += done.words;
        work.objects_projected += done.projected;
        work.illuminations += done.illuminations;
        work.shadows += done.shadows;
    }
}

/// Brings `reach` and the clearance up to date, and marks the light as stale if I must be recomputed.
fn collect_reach(
    light: &mut FrameLight,
    objects: &Objects,
    now: Seen,
    any_moved: bool,
    clearance: LightClearance,
) {
    let same_flags = light.progress.seen.map(|seen| seen.flags) == Some(now.flags);
    let new_layout = light.progress.seen.map(|seen| seen.layout) != Some(now.layout);
    let everything = light.moved || new_layout;
    light.progress.stale = everything || light.progress.seen != Some(now);
    light.progress.reach_written = everything;
    light.progress.seen = Some(now);
    if new_layout {
        let words = objects.boxes.words();
        for set in [
            &mut light.sets.reach,
            &mut light.sets.l,
            &mut light.sets.i,
            &mut light.sets.s,
            &mut light.sets.dark,
        ] {
            resize(set, objects.len());
        }
        resize(&mut light.scratch.touched, words);
        resize(&mut light.scratch.found, words);
    }
    if everything || any_moved {
        find(light, objects, everything);
    }
    if light.progress.reach_written || !same_flags {
        light.progress.clearance_share = f64::NAN;
    }
    // Lights without shadows need none.
    if light.technique.is_some() && light.progress.clearance_share != clearance.share() {
        light.progress.clearance_share = clearance.share();
        light.clearance = clearance_of(light, objects, clearance);
    }
}

/// Computes the clearance of a light. In a room it looks at few objects, otherwise at all that the light reaches.
fn clearance_of(light: &FrameLight, objects: &Objects, clearance: LightClearance) -> f64 {
    if light.point_world.w == 0.0 {
        return 0.0;
    }
    let mut around = Surroundings::new(light.point_world.truncate(), f64::from(light.light.range));
    for object in light.sets.reach.ones() {
        let casts = objects.casters.contains(object) && light.casts(objects, object);
        if around.add(&objects.boxes.get(object), casts) {
            break;
        }
    }
    clearance.metres(&around)
}

fn find(light: &mut FrameLight, objects: &Objects, everything: bool) {
    let FrameLight {
        volume,
        doors,
        sets,
        scratch: LightScratch { touched, found, .. },
        progress,
        ..
    } = light;
    let tested = &mut progress.work.words;
    let (present, moved) = (objects.present.as_slice(), objects.moved.as_slice());
    let reach = sets.reach.as_mut_slice();
    let among = (!everything).then_some(&objects.moved_words);
    let mut changed = false;
    found.clear();
    objects.clusters.find(
        among,
        |boxes, word, candidates| volume.clusters_touching(boxes, word, candidates),
        |at| {
            let mut bits = if at.inside {
                present[at.word]
            } else {
                *tested += 1;
                volume.touching(&objects.boxes, at.word, present[at.word])
            };
            if bits != 0 && !doors.planes.is_empty() {
                bits = objects.boxes.touching_planes(at.word, bits, doors);
            }
            // An object that moved within the reach, out of it or into it changes I or S.
            changed |= (reach[at.word] | bits) & moved[at.word] != 0;
            reach[at.word] = bits;
            if bits != 0 {
                found.insert(at.word);
            }
        },
    );
    // Words that were queried and not found are no longer touched.
    let mut sets = [
        sets.l.as_mut_slice(),
        sets.i.as_mut_slice(),
        sets.s.as_mut_slice(),
        sets.dark.as_mut_slice(),
    ];
    let asked = |block: usize| among.map_or(usize::MAX, |words| words.as_slice()[block]);
    for (block, (touched, found)) in touched
        .as_mut_slice()
        .iter_mut()
        .zip(found.as_slice())
        .enumerate()
    {
        let left = *touched & asked(block) & !found;
        crate::sets::index::clusters::for_bits(left, |bit| {
            let word = block * crate::sets::index::boxes::WORD + bit;
            changed |= reach[word] & moved[word] != 0;
            reach[word] = 0;
            sets.iter_mut().for_each(|set| set[word] = 0);
        });
        *touched = (*touched & !left) | found;
    }
    light.progress.stale |= changed;
    light.progress.reach_written |= changed;
}
