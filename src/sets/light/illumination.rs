//! Set I of each light, its scissor rectangle and its depth bounds.

use bevy_ecs::prelude::*;

use super::candidate::is_dark;
use super::depth_bounds::DepthBounds;
use super::frame_light::FrameLight;
use super::frame_lights::FrameLights;
use super::light_occlusion::LightOcclusion;
use super::reach::each_light;
use super::scissor::ScissorRect;
use crate::geometry::Aabb;
use crate::sets::index::boxes::WORD;
use crate::sets::index::clusters::for_bits;
use crate::sets::index::objects::Objects;
use crate::sets::occlusion::Occluders;
use crate::sets::view::frame_view::{View, ViewData};
use crate::sets::view::screen::Projector;
use crate::sets::view::screen_union::screen_union;
use crate::sets::view::visible::VisibleSet;
use crate::sets::view::visible_parts::VisibleParts;
use crate::sets::work::SetWork;

/// Bits of those objects of I in a word that show the light's shadows: receivers on the light's layers.
pub(in crate::sets) fn showing(light: &FrameLight, objects: &Objects, word: usize) -> usize {
    let receiving = light.sets.i.as_slice()[word] & objects.receivers.as_slice()[word];
    objects.selected(word, receiving, light.selection.shows_on)
}

/// Computes I of every light that needs it: I = V ∩ L ∩ drawn ∩ affected, without objects whose visible part
/// is dark. Of a companion I holds only what shows the shadows that it computes. Then computes the scissor
/// rectangle and the depth bounds, as the intersection of three bounds: those of the objects of I, those of the
/// light's volume, and those of the objects cut by the volume. If nothing is left, the light is skipped and its I
/// is emptied.
///
/// Set: `CollectSets`, after `collect_light_occlusion`. Cost: the words that the light touches, eight objects
/// at a time. Only objects that stick out of the bounds so far are projected.
/// Source: O'Rorke 2004, GPU Gems ch. 15, §15.3.3 and §15.5.
pub fn collect_illumination(
    mut frame: ResMut<FrameLights>,
    mut work: ResMut<SetWork>,
    objects: Res<Objects>,
    view: Res<View>,
    visible: Res<VisibleSet>,
    parts: Res<VisibleParts>,
    occlusion: Res<LightOcclusion>,
    occluders: Res<Occluders>,
) {
    let lights = &mut frame.lights;
    let pairs = lights.iter().filter(|light| light.progress.stale).count() * objects.boxes.words();
    each_light(lights, &mut work, pairs, |light| {
        if !light.progress.stale {
            return;
        }
        light.progress.work.illuminations += 1;
        (light.region.scissor, light.region.depth_bounds) = (None, None);
        light.region.receiver_bounds = Aabb::EMPTY;
        let dark = light.sets.dark.as_mut_slice();
        light.scratch.touched.ones().for_each(|word| dark[word] = 0);
        let shines = !is_dark(&light.light) && light.is_in_use();
        let bounds = view.data.as_ref().filter(|_| shines).and_then(|view| {
            intersect(light, &objects, &visible);
            parts.cut_illumination(light, occlusion.viewpoint_of(light), &occluders);
            bound(light, &objects, view, &parts)
        });
        match bounds {
            Some((scissor, depth_bounds)) => {
                (light.region.scissor, light.region.depth_bounds) = (Some(scissor), Some(depth_bounds));
            }
            None => {
                let i = light.sets.i.as_mut_slice();
                light.scratch.touched.ones().for_each(|word| i[word] = 0);
            }
        }
    });
}

fn intersect(light: &mut FrameLight, objects: &Objects, visible: &VisibleSet) {
    let (v, l) = (visible.set.as_slice(), light.sets.l.as_slice());
    let drawn = objects.drawn.as_slice();
    let i = light.sets.i.as_mut_slice();
    for word in light.scratch.touched.ones() {
        let candidates = v[word] & l[word] & drawn[word];
        i[word] = objects.selected(word, candidates, light.selection.affects);
        if light.companion_of.is_some() {
            let receivers = i[word] & objects.receivers.as_slice()[word];
            let showing = objects.selected(word, receivers, light.selection.shows_on);
            i[word] = light.acts_on.receivers.among(word, showing);
        }
        if light.lit.has_near() {
            for_bits(i[word], |lane| {
                if light.lit.is_too_near(&objects.boxes.get(word * WORD + lane)) {
                    i[word] &= !(1 << lane);
                }
            });
        }
    }
    let (reach, dark) = (light.sets.reach.as_slice(), light.sets.dark.as_mut_slice());
    for word in light.scratch.touched.ones() {
        let candidates = v[word] & reach[word] & !l[word] & drawn[word];
        dark[word] = objects.selected(word, candidates, light.selection.affects);
    }
}

fn bound(
    light: &mut FrameLight,
    objects: &Objects,
    view: &ViewData,
    parts: &VisibleParts,
) -> Option<(ScissorRect, DepthBounds)> {
    let reach = light.lit.aabb();
    let i = light.sets.i.as_slice();
    let shows = |word: usize| showing(light, objects, word);
    let bounds_of =
        |set: &dyn Fn(usize) -> usize| parts.lit_bounds(objects, &light.scratch.touched, set, &reach);
    let lit = bounds_of(&|word| i[word]);
    if lit.is_empty() {
        return None;
    }
    // Usually all objects are receivers, and then one pass also serves S.
    let all_receive = light
        .scratch
        .touched
        .ones()
        .all(|word| i[word] & !shows(word) == 0);
    light.region.receiver_bounds = if all_receive {
        lit
    } else {
        bounds_of(&|word| shows(word))
    };
    let projector = Projector::new(view);
    let mut target = light.lit.screen_bounds(&projector);
    if reach.max.is_finite() && reach.min.is_finite() {
        let lit = projector.bounds_of_box(lit.center().as_dvec3(), lit.half_size().as_dvec3());
        target = target.intersection(lit);
    }
    let (union, projected) = screen_union(
        &projector,
        objects,
        &light.scratch.touched,
        |word| i[word],
        target,
    );
    light.progress.work.projected += projected;
    let bounds = union.intersection(target);
    let scissor = ScissorRect::around(&bounds, view.viewport)?;
    let depth_bounds = DepthBounds::of_screen(&bounds, view.depth)?;
    Some((scissor, depth_bounds))
}
