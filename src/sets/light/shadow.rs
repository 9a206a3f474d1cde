//! Set S of each light: casters whose shadow can reach what the light lights in view.

use bevy_ecs::prelude::*;
use smallvec::SmallVec;

use super::frame_light::FrameLight;
use super::frame_lights::FrameLights;
use super::light_volume::LightVolume;
use super::lit_receivers::{cut_casters, list_lit_receivers};
use super::reach::each_light;
use crate::geometry::{LightHull, Plane, Sphere};
use crate::scene::LocalBounds;
use crate::scene::placement::Placement;
use crate::sets::index::boxes::WORD;
use crate::sets::index::clusters::for_bits;
use crate::sets::index::objects::Objects;
use crate::sets::occlusion::OcclusionSettings;
use crate::sets::view::frame_view::{View, ViewData};
use crate::sets::view::frustum::FrustumSet;
use crate::sets::view::visible_parts::VisibleParts;
use crate::sets::work::SetWork;

/// Computes S of every light that needs it.
///
/// Candidates are the casters of L that cast for this light. A candidate must pass every test: (1) If the
/// whole light is inside the frustum, the candidate is in F; otherwise it touches the convex hull of light
/// and frustum. (2) It touches the convex hull of the light and the bounds of I's receivers within the
/// light's volume. (3) If something occludes, it touches the hull of the light and one of those receivers.
/// (4) If the light's volume is a ball, the caster's local bounds, placed in the world, touch it, which is
/// tighter than the test of its world bounds. Without receivers S is empty.
///
/// If [`OcclusionSettings::of_shadows`] is off, S is all casters of L that cast for the light.
///
/// Set: `CollectSets`, last. Conservative: it may keep a caster too many, but never drops one that matters,
/// not even for one point of an area light (`tests/core/sets_never_drop.rs` holds it against brute force). Cost:
/// the clusters that the light touches, and the objects of those clusters that a plane of the hulls cuts,
/// against those planes alone.
/// Source: O'Rorke 2004, GPU Gems ch. 15, §15.4.4; the second and third hull are ours.
pub fn collect_shadow_sets(
    mut frame: ResMut<FrameLights>,
    mut work: ResMut<SetWork>,
    objects: Res<Objects>,
    view: Res<View>,
    frustum_set: Res<FrustumSet>,
    placed: Query<Placed>,
    settings: Res<OcclusionSettings>,
    parts: Res<VisibleParts>,
) {
    let lights = &mut frame.lights;
    let pairs = lights.iter().filter(|light| light.progress.stale).count() * objects.boxes.words();
    each_light(lights, &mut work, pairs, |light| {
        if !light.progress.stale {
            return;
        }
        light.hulls.inside_frustum = false;
        match &view.data {
            Some(view) if light.region.scissor.is_some() => {
                light.progress.work.shadows += 1;
                collect(light, &objects, view, &frustum_set, &placed);
                list_lit_receivers(light, &parts, &objects);
                if settings.of_shadows {
                    cut_casters(light, &parts, &objects);
                } else if !light.region.receiver_bounds.is_empty() {
                    all_casters(light, &objects);
                }
            }
            _ => clear(light),
        }
    });
}

/// Sets S to all casters of L that cast for the light.
fn all_casters(light: &mut FrameLight, objects: &Objects) {
    let mut set = std::mem::take(&mut light.sets.s);
    let (l, casters) = (light.sets.l.as_slice(), objects.casters.as_slice());
    let s = set.as_mut_slice();
    for word in light.scratch.touched.ones() {
        s[word] = light.casting(objects, word, l[word] & casters[word]);
    }
    light.sets.s = set;
}

fn clear(light: &mut FrameLight) {
    let s = light.sets.s.as_mut_slice();
    light.scratch.touched.ones().for_each(|word| s[word] = 0);
    light.region.lit_receivers.clear();
}

/// Local bounds of a caster, and its placement in world space.
type Placed = (&'static LocalBounds, Placement);

fn collect(
    light: &mut FrameLight,
    objects: &Objects,
    view: &ViewData,
    frustum_set: &FrustumSet,
    placed: &Query<Placed>,
) {
    light.hulls.view = LightHull::of_frustum(&view.frustum, &light.emitter);
    light.hulls.inside_frustum = light.hulls.view.inside;
    if light.region.receiver_bounds.is_empty() {
        light.hulls.receivers = LightHull::default();
        clear(light);
        return;
    }
    light.hulls.receivers = LightHull::of_aabb(&light.region.receiver_bounds, &light.emitter);
    // If the light is inside the frustum, F already stands for the planes of the first hull.
    let view_planes: &[Plane] = if light.hulls.inside_frustum {
        &[]
    } else {
        &light.hulls.view.planes.planes
    };
    let mut set = std::mem::take(&mut light.sets.s);
    let mut cutting = std::mem::take(&mut light.scratch.cutting);
    let (l, f) = (light.sets.l.as_slice(), frustum_set.set.as_slice());
    let casters = objects.casters.as_slice();
    let words = set.as_mut_slice();
    for word in light.scratch.touched.ones() {
        let mut s = l[word] & casters[word];
        if light.hulls.inside_frustum {
            s &= f[word];
        }
        if s != 0 {
            let planes = view_planes.iter().chain(&light.hulls.receivers.planes.planes);
            s = match cut(objects, word, planes, &mut cutting.planes) {
                false => 0,
                true if cutting.planes.is_empty() => s,
                true => objects.boxes.touching_planes(word, s, &cutting),
            };
        }
        s = light.casting(objects, word, s);
        if let (LightVolume::Ball(ball), true) = (light.volume, s != 0) {
            s &= !beyond(&ball, objects, word, s, placed);
        }
        words[word] = s;
    }
    (light.sets.s, light.scratch.cutting) = (set, cutting);
}

/// Bits of those casters of a word whose placed local bounds the ball excludes. Only casters centred beyond
/// its range are tested.
fn beyond(ball: &Sphere, objects: &Objects, word: usize, s: usize, placed: &Query<Placed>) -> usize {
    let mut beyond = 0;
    for_bits(objects.boxes.centered_beyond(word, s, ball), |bit| {
        if let Ok((local, place)) = placed.get(objects.entities[word * WORD + bit])
            && place
                .affine()
                .is_some_and(|affine| ball.excludes_oriented(&local.0, &affine))
        {
            beyond |= 1 << bit;
        }
    });
    beyond
}

/// Collects the planes that leave a part of the word's cluster outside. Returns `false` if one plane leaves
/// the whole cluster outside.
fn cut<'a>(
    objects: &Objects,
    word: usize,
    planes: impl Iterator<Item = &'a Plane>,
    cutting: &mut SmallVec<[Plane; 16]>,
) -> bool {
    cutting.clear();
    let (center, half) = objects.clusters.words.load(word);
    for plane in planes {
        let distance = plane.distance(center);
        let reach = plane.normal.abs().dot(half);
        if distance + reach < 0.0 {
            return false;
        }
        if distance - reach < 0.0 {
            cutting.push(*plane);
        }
    }
    true
}
