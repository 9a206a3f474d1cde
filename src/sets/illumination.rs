//! Set I of each light, its scissor rectangle and its depth bounds.

use bevy_ecs::prelude::*;

use super::boxes::WORD;
use super::depth_bounds::DepthBounds;
use super::light_occlusion::LightOcclusion;
use super::lights::{FrameLight, FrameLights, is_dark};
use super::objects::{Objects, resize};
use super::occlusion::Occluders;
use super::scissor::ScissorRect;
use super::screen::{Projector, ScreenBounds, ScreenExtents};
use super::view::{View, ViewData};
use super::visible::VisibleSet;
use super::visible_parts::VisibleParts;
use super::work::SetWork;
use crate::geometry::Aabb;

/// Bits of a word of objects whose layers share a bit with the mask.
pub(super) fn selected(objects: &Objects, word: usize, bits: usize, mask: u32) -> usize {
    if objects.common_layers & mask != 0 {
        return bits;
    }
    let mut result = 0;
    let mut rest = bits;
    while rest != 0 {
        let lane = rest.trailing_zeros() as usize;
        rest &= rest - 1;
        if objects.layers[word * WORD + lane] & mask != 0 {
            result |= 1 << lane;
        }
    }
    result
}

/// The bounds of visible parts of objects, each cut by the box of a light's volume, joined.
pub(super) fn lit_bounds(
    objects: &Objects,
    parts: &VisibleParts,
    indices: impl Iterator<Item = usize>,
    reach: &Aabb,
) -> Aabb {
    indices
        .map(|index| parts.get(objects, index).intersection(*reach))
        .filter(|part| !part.is_empty())
        .fold(Aabb::EMPTY, Aabb::union)
}

/// Computes I = V ∩ L ∩ drawn ∩ affected of every light that needs it, less objects of which all that is seen is dark, then the scissor and depth bounds: those of I's
/// objects, of the light's volume, and of the objects cut by the volume, intersected. If nothing is left the light
/// is skipped: I is emptied.
///
/// Set: `CollectSets`, after `collect_light_sets` and `project_visible`. Word-wise; then O(|I|), without projections.
/// Source: O'Rorke 2004, GPU Gems ch. 15, §15.3.3 and §15.5.
pub fn collect_illumination(
    mut frame: ResMut<FrameLights>,
    mut work: ResMut<SetWork>,
    objects: Res<Objects>,
    view: Res<View>,
    visible: Res<VisibleSet>,
    extents: Res<ScreenExtents>,
    parts: Res<VisibleParts>,
    occlusion: Res<LightOcclusion>,
    occluders: Res<Occluders>,
) {
    for (at, light) in frame
        .lights
        .iter_mut()
        .enumerate()
        .filter(|(_, light)| light.stale)
    {
        resize(&mut light.i, objects.len());
        resize(&mut light.dark, objects.len());
        light.scissor = None;
        light.depth_bounds = None;
        work.illuminations += 1;
        let Some(view) = &view.data else {
            continue;
        };
        if !is_dark(&light.light) {
            intersect(light, &objects, &visible);
            parts.cut_illumination(light, occlusion.viewpoint(at), &occluders);
        }
        if !light.i.is_clear() && bound(light, &objects, view, &extents, &parts).is_none() {
            light.scissor = None;
            light.depth_bounds = None;
            light.i.clear();
        }
    }
}

fn intersect(light: &mut FrameLight, objects: &Objects, visible: &VisibleSet) {
    let (v, l) = (visible.set.as_slice(), light.l.as_slice());
    let drawn = objects.drawn.as_slice();
    for (word, bits) in light.i.as_mut_slice().iter_mut().enumerate() {
        let candidates = v[word] & l[word] & drawn[word];
        *bits = selected(objects, word, candidates, light.selection.affects);
    }
    let reach = light.reach.as_slice();
    for (word, bits) in light.dark.as_mut_slice().iter_mut().enumerate() {
        let candidates = v[word] & reach[word] & !l[word] & drawn[word];
        *bits = selected(objects, word, candidates, light.selection.affects);
    }
}

fn bound(
    light: &mut FrameLight,
    objects: &Objects,
    view: &ViewData,
    extents: &ScreenExtents,
    parts: &VisibleParts,
) -> Option<()> {
    let projector = Projector::new(view);
    let mut bounds = light
        .i
        .ones()
        .map(|index| extents.bounds[index])
        .fold(ScreenBounds::EMPTY, ScreenBounds::union)
        .intersection(light.volume.screen_bounds(&projector));
    let reach = light.volume.aabb();
    // Mostly all are receivers, and one pass serves S too.
    let lit = lit_bounds(objects, parts, light.i.ones(), &reach);
    light.receiver_bounds = if light.i.is_subset(&objects.receivers) {
        lit
    } else {
        lit_bounds(objects, parts, light.i.intersection(&objects.receivers), &reach)
    };
    if lit.is_empty() {
        return None;
    }
    if reach.max.is_finite() && reach.min.is_finite() {
        let lit = projector.bounds_of_box(lit.center().as_dvec3(), lit.half_size().as_dvec3());
        bounds = bounds.intersection(lit);
    }
    light.scissor = Some(ScissorRect::around(&bounds, view.viewport)?);
    light.depth_bounds = Some(DepthBounds::of_screen(&bounds, view.near)?);
    Some(())
}
