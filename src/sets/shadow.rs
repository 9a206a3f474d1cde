//! Set S of each light: casters whose shadow can reach what the light lights in view.

use bevy_ecs::prelude::*;

use super::frustum::FrustumSet;
use super::illumination::selected;
use super::lights::{FrameLight, FrameLights};
use super::objects::{Objects, resize};
use super::occlusion::OcclusionSettings;
use super::view::{View, ViewData};
use super::visible_parts::{VisibleParts, cut_casters};
use super::work::SetWork;
use crate::geometry::LightHull;

/// Computes S of every light that needs it.
///
/// Candidates are the casters of L that cast for this light. If all of the light is inside the frustum, those in F stay;
/// else those that touch the convex hull of light and frustum. Of these, only those stay that touch the convex hull of
/// light and the bounds of I's receivers within the light's volume, and the hull of light and one of these. Without
/// receivers S is empty.
///
/// [`OcclusionSettings::of_shadows`] off leaves S at all casters of L that cast for the light.
///
/// Set: `CollectSets`, last. Conservative: it may keep a caster too many, it never drops one that matters
/// (`tests/sets_never_drop.rs` holds it against brute force), not even for one point of an area light.
/// Source: O'Rorke 2004, GPU Gems ch. 15, §15.4.4; the second and third hull are ours.
pub fn collect_shadow_sets(
    mut frame: ResMut<FrameLights>,
    mut work: ResMut<SetWork>,
    objects: Res<Objects>,
    view: Res<View>,
    frustum_set: Res<FrustumSet>,
    settings: Res<OcclusionSettings>,
    parts: Res<VisibleParts>,
) {
    for light in frame.lights.iter_mut().filter(|light| light.stale) {
        resize(&mut light.s, objects.len());
        resize(&mut light.kept, objects.len());
        light.inside_frustum = false;
        if let Some(view) = &view.data
            && !light.i.is_clear()
        {
            work.shadows += 1;
            collect(light, &objects, view, &frustum_set);
            if settings.of_shadows {
                cut_casters(light, &parts, &objects);
            } else if !light.receiver_bounds.is_empty() {
                all_casters(light, &objects);
            }
        }
    }
}

/// S as it is without a shadow set: whatever of L casts for the light.
fn all_casters(light: &mut FrameLight, objects: &Objects) {
    let (l, casters) = (light.l.as_slice(), objects.casters.as_slice());
    for (word, bits) in light.s.as_mut_slice().iter_mut().enumerate() {
        *bits = selected(objects, word, l[word] & casters[word], light.selection.casts_for);
    }
}

fn collect(light: &mut FrameLight, objects: &Objects, view: &ViewData, frustum_set: &FrustumSet) {
    light.hull = LightHull::of_frustum(&view.frustum, &light.emitter);
    light.inside_frustum = light.hull.inside;
    if light.receiver_bounds.is_empty() {
        light.receiver_hull = LightHull::default();
        return;
    }
    light.receiver_hull = LightHull::of_aabb(&light.receiver_bounds, &light.emitter);
    let (l, f) = (light.l.as_slice(), frustum_set.set.as_slice());
    let casters = objects.casters.as_slice();
    for (word, bits) in light.s.as_mut_slice().iter_mut().enumerate() {
        let mut s = l[word] & casters[word];
        if light.inside_frustum {
            s &= f[word];
        }
        if s != 0 && !light.inside_frustum {
            s = objects.boxes.touching_planes(word, s, &light.hull.planes);
        }
        if s != 0 {
            s = objects
                .boxes
                .touching_planes(word, s, &light.receiver_hull.planes);
        }
        *bits = selected(objects, word, s, light.selection.casts_for);
    }
}
