//! Set V: objects of F that the camera may see.

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;

use super::frame_view::{View, ViewData};
use super::frustum::FrustumSet;
use super::screen::Projector;
use super::visible_parts::VisibleParts;
use crate::sets::index::boxes::WORD;
use crate::sets::index::objects::Objects;
use crate::sets::occlusion::viewpoint::Blocks;
use crate::sets::occlusion::{
    Cells, Occluders, OcclusionSettings, Projection, Rasterizer, Sightings, Standpoint, Viewpoint,
};
use crate::sets::work::SetWork;

/// The set V: objects of F that the camera may see. Written by [`collect_visible_set`].
#[derive(Resource, Clone, Debug, Default)]
pub struct VisibleSet {
    /// Objects of F that are not occluded from the camera.
    pub set: FixedBitSet,
    /// Increases when objects may have entered or left the set for another reason than their own motion.
    pub generation: u64,
    seen: Option<Seen>,
    previous: FixedBitSet,
}

/// Everything that V depends on, apart from motion.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    frustum_set: u64,
    occluders: u64,
    cells: u64,
    settings: OcclusionSettings,
}

/// The occluders that the camera sees. Written by [`collect_visible_set`].
#[derive(Resource, Clone, Debug, Default)]
pub struct CameraOcclusion {
    /// The camera's depth buffer, from the last frame in which the view or the occluders changed.
    pub viewpoint: Viewpoint,
    /// Increases when `viewpoint` is drawn again.
    pub generation: u64,
    sightings: Sightings,
    rasterizer: Rasterizer,
}

/// Computes V: F without objects that no portal shows, and without objects that the camera's depth buffer
/// hides.
///
/// Set: `CollectSets`, after `collect_frustum_set` and `collect_occluders`. The buffer is redrawn when the
/// view or the occluders changed or an occluder moved in view, and then all of F is tested. Otherwise only
/// objects that moved are tested. Conservative: it may keep a hidden object, but never drops one that shows
/// in a pixel.
pub fn collect_visible_set(
    mut visible: ResMut<VisibleSet>,
    mut occlusion: ResMut<CameraOcclusion>,
    mut parts: ResMut<VisibleParts>,
    mut work: ResMut<SetWork>,
    frustum_set: Res<FrustumSet>,
    objects: Res<Objects>,
    occluders: Res<Occluders>,
    cells: Res<Cells>,
    settings: Res<OcclusionSettings>,
    view: Res<View>,
) {
    let now = Seen {
        frustum_set: frustum_set.generation,
        occluders: occluders.generation,
        cells: cells.generation,
        settings: *settings,
    };
    let (visible, occlusion) = (&mut *visible, &mut *occlusion);
    let anew = visible.seen != Some(now);
    if !anew && objects.moved.is_clear() {
        return;
    }
    visible.seen = Some(now);
    let redraw = settings.from_camera && (anew || occluder_moved(occlusion, &occluders, &frustum_set.set));
    if anew || redraw {
        if visible.set.len() != frustum_set.set.len() {
            visible.set = FixedBitSet::with_capacity(frustum_set.set.len());
            visible.previous = visible.set.clone();
        }
        std::mem::swap(&mut visible.set, &mut visible.previous);
        visible.set.clone_from(&frustum_set.set);
        if anew {
            look_around(&mut occlusion.sightings, &cells, &settings, &view);
        }
        if occlusion.sightings.is_limited() {
            for (word, bits) in visible.set.as_mut_slice().iter_mut().enumerate() {
                *bits = occlusion.sightings.seen_of_word(&cells, &objects, word, *bits);
            }
        }
        draw(occlusion, &visible.set, &objects, &occluders, &settings, &view);
        occlusion.generation += 1;
        let mut changed = false;
        if occlusion.viewpoint.buffers().is_empty() {
            parts.forget();
        } else {
            work.depth_buffers += 1;
            work.occlusion_tests += visible.set.count_ones(..) as u64;
            parts.begin(objects.len());
            for word in 0..visible.set.as_slice().len() {
                let mut rest = visible.set.as_slice()[word];
                while rest != 0 {
                    let object = word * WORD + rest.trailing_zeros() as usize;
                    rest &= rest - 1;
                    let part = occlusion.viewpoint.visible_part(&objects, object);
                    visible.set.set(object, !part.is_empty());
                    changed |= parts.set(object, part) && !objects.moved.contains(object);
                }
            }
        }
        if anew || changed || differs_at_rest(visible, &objects) {
            visible.generation += 1;
        }
        return;
    }
    for word in objects.moved_words.ones() {
        let moved = objects.moved.as_slice()[word];
        let bits = &mut visible.set.as_mut_slice()[word];
        let candidates = frustum_set.set.as_slice()[word] & moved;
        let seen = occlusion
            .sightings
            .seen_of_word(&cells, &objects, word, candidates);
        *bits = *bits & !moved | seen;
    }
    if occlusion.viewpoint.buffers().is_empty() {
        return;
    }
    for object in objects.moved.ones() {
        if !visible.set.contains(object) {
            continue;
        }
        work.occlusion_tests += 1;
        let part = occlusion.viewpoint.visible_part(&objects, object);
        visible.set.set(object, !part.is_empty());
        parts.set(object, part);
    }
}

/// Looks through the portals from the camera's cells. An orthographic view stands in no cell, so it is
/// skipped.
///
/// The near rectangle must be in cells too, because a wall in front of it is not drawn and hides nothing.
fn look_around(sightings: &mut Sightings, cells: &Cells, settings: &OcclusionSettings, view: &View) {
    sightings.forget();
    let looks = |view: &&ViewData| settings.from_camera && !cells.is_empty() && !view.is_orthographic();
    let Some(view) = view.data.as_ref().filter(looks) else {
        return;
    };
    let corners = view.near_corners.map(|corner| corner - view.eye);
    let around = [corners[0], corners[1], corners[3], corners[2]];
    let standpoint = Standpoint {
        eye: view.eye,
        points: std::iter::once(view.eye).chain(view.near_corners).collect(),
        reach: corners.iter().map(|corner| corner.length()).fold(0.0, f64::max) * (1.0 + 1e-6),
        corners: around.into_iter().collect(),
        clips: true,
        range: f64::INFINITY,
    };
    sightings.flood(cells, &standpoint);
}

/// Draws the depth buffer. Draws none if nothing can occlude.
fn draw(
    occlusion: &mut CameraOcclusion,
    frustum_set: &FixedBitSet,
    objects: &Objects,
    occluders: &Occluders,
    settings: &OcclusionSettings,
    view: &View,
) {
    occlusion.viewpoint.clear();
    let candidates = || frustum_set.intersection(&occluders.camera);
    let Some(view) = &view.data else { return };
    if !settings.from_camera || candidates().next().is_none() {
        return;
    }
    let projection = Projection::of_view(view, settings.camera_texels.clamp(16, 2048));
    // Occluders in front of the near plane hide nothing. An orthographic picture is not clipped there, so
    // occluders that reach in front of the plane are left out of it.
    let projector = Projector::new(view);
    let gradient = projector.depth_gradient().abs();
    let is_behind_near = |&object: &usize| {
        let (center, half) = objects.boxes.center_half(object);
        !view.is_orthographic() || projector.depth(center) - gradient.dot(half) >= view.near
    };
    occlusion.viewpoint.draw(
        &mut occlusion.rasterizer,
        &[projection],
        candidates().filter(is_behind_near),
        objects,
        occluders,
        settings,
        Blocks::Sight,
    );
}

/// Whether an occluder moved that is in the depth buffer, or that is now within the frustum.
fn occluder_moved(occlusion: &CameraOcclusion, occluders: &Occluders, frustum_set: &FixedBitSet) -> bool {
    let mut moved = occluders.moved.intersection(&occluders.camera);
    moved.any(|object| frustum_set.contains(object) || occlusion.viewpoint.drawn.contains(object))
}

/// Whether V changed by an object that did not move.
fn differs_at_rest(visible: &VisibleSet, objects: &Objects) -> bool {
    let (new, old, moved) = (
        visible.set.as_slice(),
        visible.previous.as_slice(),
        objects.moved.as_slice(),
    );
    new.iter()
        .zip(old)
        .zip(moved)
        .any(|((new, old), moved)| (new ^ old) & !moved != 0)
}
