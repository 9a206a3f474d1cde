//! Set L of each light: the objects that it reaches and may see.

use bevy_ecs::prelude::*;
use bevy_tasks::ComputeTaskPool;

use super::companion::CompanionOf;
use super::frame_light::FrameLight;
use super::frame_lights::FrameLights;
use crate::geometry::Aabb;
use crate::scene::tasks;
use crate::sets::index::objects::Objects;
use crate::sets::occlusion::light_views::light_views;
use crate::sets::occlusion::viewpoint::Blocks;
use crate::sets::occlusion::{
    Cells, Occluders, OcclusionSettings, Rasterizer, Sightings, Standpoint, Viewpoint,
};
use crate::sets::work::SetWork;

/// The occluders of each light. Written by [`collect_light_occlusion`].
#[derive(Resource, Clone, Debug, Default)]
pub struct LightOcclusion {
    /// One entry for each light of [`FrameLights`], in the same order.
    lights: Vec<Entry>,
    previous: Vec<Entry>,
    frame_lights: u64,
    /// One piece of working memory for each piece of the lights.
    pieces: Vec<Piece>,
}

/// Working memory and counters of one thread.
#[derive(Clone, Debug, Default)]
struct Piece {
    rasterizer: Rasterizer,
    depth_buffers: u64,
    occlusion_tests: u64,
}

#[derive(Clone, Debug)]
struct Entry {
    /// [`FrameLight::order`] of the light.
    light: (Option<CompanionOf>, Entity),
    viewpoint: Viewpoint,
    sightings: Sightings,
    seen: Option<Seen>,
}

/// Everything that lights are tested against.
struct Scene<'a> {
    objects: &'a Objects,
    occluders: &'a Occluders,
    cells: &'a Cells,
    settings: &'a OcclusionSettings,
}

/// Everything that occlusion from a light depends on, apart from the light itself and motion.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    occluders: u64,
    cells: u64,
    settings: OcclusionSettings,
    clearance: f64,
    wants_occlusion: bool,
}

impl LightOcclusion {
    /// The occlusion of the light with this index in [`FrameLights`].
    pub fn viewpoint(&self, light: usize) -> Option<&Viewpoint> {
        Some(&self.lights.get(light)?.viewpoint)
    }

    /// The occlusion of a light of [`FrameLights`].
    pub(in crate::sets) fn viewpoint_of(&self, light: &FrameLight) -> Option<&Viewpoint> {
        let at = self
            .lights
            .binary_search_by_key(&light.order(), |entry| entry.light)
            .ok()?;
        Some(&self.lights[at].viewpoint)
    }

    /// Keeps the entries of lights that still exist.
    fn follow(&mut self, frame: &FrameLights) {
        if self.frame_lights == frame.generation && self.lights.len() == frame.lights.len() {
            return;
        }
        self.frame_lights = frame.generation;
        std::mem::swap(&mut self.lights, &mut self.previous);
        let mut old = self.previous.drain(..).peekable();
        for light in &frame.lights {
            while old.next_if(|entry| entry.light < light.order()).is_some() {}
            let known = old.next_if(|entry| entry.light == light.order());
            self.lights.push(known.unwrap_or_else(|| Entry {
                light: light.order(),
                viewpoint: Viewpoint::default(),
                sightings: Sightings::default(),
                seen: None,
            }));
        }
    }
}

/// Computes L: the light's reach without objects that no portal shows to the light, and without objects that
/// its depth buffers hide.
///
/// Only casters of the light hide anything from it, and of these only such without a triangle in the light's clearance
/// ([`LightClearance`](super::clearance::LightClearance)), because a technique lets light pass there. Only objects that are dark wherever the light does not
/// see them are left out: objects whose every surface shows shadows, and casters that are not drawn. Lights
/// whose technique does not ask for it ([`Needs::light_occlusion`](super::technique::Needs)) see everything in
/// their reach. Lights with an extent have no depth buffers;
/// only portals limit what they see. A light's buffers are redrawn when the light, or an occluder within its
/// reach, moved; then all objects that it reaches are tested, and I and S are recomputed. Otherwise only
/// objects that moved are tested. Lights are spread over the threads of the [`ComputeTaskPool`].
///
/// Set: `CollectSets`, after `collect_light_sets`. Conservative: it may keep an object that the light does
/// not see.
/// Source: O'Rorke 2004, GPU Gems ch. 15, §15.4.2, with the cube of six pictures.
pub fn collect_light_occlusion(
    mut frame: ResMut<FrameLights>,
    mut occlusion: ResMut<LightOcclusion>,
    mut work: ResMut<SetWork>,
    objects: Res<Objects>,
    occluders: Res<Occluders>,
    cells: Res<Cells>,
    settings: Res<OcclusionSettings>,
) {
    let occlusion = &mut *occlusion;
    occlusion.follow(&frame);
    let LightOcclusion { lights, pieces, .. } = occlusion;
    let now = |light: &FrameLight| Seen {
        occluders: occluders.generation,
        cells: cells.generation,
        settings: *settings,
        clearance: light.clearance,
        // A light may light what it does not see: if its shadows are not black, or do not show there. Pictures of what it
        // sees are taken from where it shines, which need not be where its shadows come from.
        // Companions complete the shadow of an extended light, of which they know the middle alone.
        wants_occlusion: light.needs().light_occlusion
            && light.companion_of.is_none()
            && !light.model.lights_shadows()
            && light.model.origin.is_none()
            && (light.selection.shows_on == u32::MAX
                || objects.common_layers() & light.selection.shows_on != 0),
    };
    let pairs = || frame.lights.iter().zip(&*lights);
    let awake =
        pairs().filter(|(light, entry)| light.progress.reach_written || is_new(light, entry, &now(light)));
    let parallel = awake.take(2).count() > 1;
    let threads = ComputeTaskPool::try_get().map_or(1, |pool| pool.thread_num());
    // A piece is smaller than a thread's share, because neighbouring lights may be the costly ones.
    let piece_count = if parallel { 4 * threads.max(1) } else { 1 };
    let size = frame.lights.len().div_ceil(piece_count).max(1);
    if pieces.len() < piece_count {
        pieces.resize_with(piece_count, Piece::default);
    }
    let scene = Scene {
        objects: &objects,
        occluders: &occluders,
        cells: &cells,
        settings: &settings,
    };
    let chunks = frame.lights.chunks_mut(size).zip(lights.chunks_mut(size));
    tasks::for_each(
        chunks.zip(&mut *pieces),
        parallel,
        |((lights, entries), piece)| {
            for (light, entry) in lights.iter_mut().zip(entries) {
                let now = now(light);
                find_seen(light, entry, now, piece, &scene);
            }
        },
    );
    for piece in pieces {
        work.depth_buffers += std::mem::take(&mut piece.depth_buffers);
        work.occlusion_tests += std::mem::take(&mut piece.occlusion_tests);
    }
}

/// Whether every object in the light's reach must be tested.
fn is_new(light: &FrameLight, entry: &Entry, now: &Seen) -> bool {
    light.moved || entry.seen.as_ref() != Some(now)
}

/// Computes set L of one light.
fn find_seen(light: &mut FrameLight, entry: &mut Entry, now: Seen, piece: &mut Piece, scene: &Scene) {
    let Scene {
        objects,
        occluders,
        cells,
        settings,
        ..
    } = *scene;
    let anew = is_new(light, entry, &now);
    if !anew && !light.progress.reach_written {
        return;
    }
    entry.seen = Some(now);
    if !(settings.from_lights && now.wants_occlusion) {
        entry.viewpoint.clear();
        entry.sightings.forget();
        light.progress.stale |= anew;
        see_all(light);
        return;
    }
    if anew {
        look_around(&mut entry.sightings, light, cells);
    }
    let unseen = |entry: &Entry, object: usize| {
        !entry.sightings.sees(cells, objects, object) || entry.viewpoint.hides(objects, object)
    };
    if anew || occluder_moved(light, &entry.viewpoint, objects, occluders) {
        draw(light, &mut entry.viewpoint, &mut piece.rasterizer, scene);
        piece.depth_buffers += entry.viewpoint.buffers().len() as u64;
        see_all(light);
        for object in light.sets.reach.intersection(&occluders.shadeable) {
            piece.occlusion_tests += 1;
            if unseen(entry, object) {
                light.sets.l.remove(object);
            }
        }
        // Even if L is unchanged, the visible parts of its objects may have become lit or dark.
        light.progress.stale = true;
        return;
    }
    for word in objects.moved_words.ones() {
        let moved = objects.moved.as_slice()[word];
        let bits = &mut light.sets.l.as_mut_slice()[word];
        *bits = *bits & !moved | light.sets.reach.as_slice()[word] & moved;
    }
    for object in objects.moved.intersection(&occluders.shadeable) {
        if light.sets.l.contains(object) {
            piece.occlusion_tests += 1;
            if unseen(entry, object) {
                light.sets.l.remove(object);
            }
        }
    }
}

/// Sets L to the light's reach. Words that the light no longer touches were cleared together with those of
/// `reach`.
fn see_all(light: &mut FrameLight) {
    let (l, reach) = (light.sets.l.as_mut_slice(), light.sets.reach.as_slice());
    light
        .scratch
        .touched
        .ones()
        .for_each(|word| l[word] = reach[word]);
}

/// Looks through the portals from the light's cells, as far as the light reaches. Directional lights are
/// skipped, because they stand in no cell, and so are lights for which the cells' walls do not cast. An area
/// light looks from its whole extent: through all connected portals, without clipping.
fn look_around(sightings: &mut Sightings, light: &FrameLight, cells: &Cells) {
    sightings.forget();
    if cells.is_empty() || light.point_world.w == 0.0 || !cells.cast_for(light.selection.casts_for) {
        return;
    }
    let eye = light.point_world.truncate();
    let extent = light.emitter.bounding_radius();
    let corner = |i: u8| {
        let sign = |bit: u8| if i & bit == 0 { -extent } else { extent };
        eye + glam::DVec3::new(sign(1), sign(2), sign(4))
    };
    let standpoint = Standpoint {
        eye,
        points: if extent > 0.0 {
            (0..8).map(corner).collect()
        } else {
            [eye].into_iter().collect()
        },
        reach: extent + 1e-4 + 1e-6 * eye.abs().max_element(),
        corners: Default::default(),
        clips: extent == 0.0,
        range: f64::from(light.light.range),
    };
    sightings.flood(cells, &standpoint);
}

/// Whether an object may hide others from this light.
fn hides_from(light: &FrameLight, objects: &Objects, occluders: &Occluders, object: usize) -> bool {
    occluders.light.contains(object) && objects.layers[object] & light.selection.casts_for != 0
}

/// Whether an occluder moved that was drawn for the light, or that is within its reach.
fn occluder_moved(
    light: &FrameLight,
    viewpoint: &Viewpoint,
    objects: &Objects,
    occluders: &Occluders,
) -> bool {
    occluders.moved.ones().any(|object| {
        hides_from(light, objects, occluders, object)
            && (light.sets.reach.contains(object) || viewpoint.drawn.contains(object))
    })
}

/// Whether a triangle of an object is in the light's clearance, where it blocks nothing.
fn is_in_clearance(light: &FrameLight, scene: &Scene, object: usize) -> bool {
    let bounds = scene.objects.boxes.get(object);
    let clearance = light.clearance;
    let point = light.point_world.truncate();
    let nearest = point.clamp(bounds.min.as_dvec3(), bounds.max.as_dvec3());
    clearance > 0.0
        && point.distance(nearest) <= clearance
        && scene.occluders.comes_near(object, point, clearance)
}

fn draw(light: &FrameLight, viewpoint: &mut Viewpoint, rasterizer: &mut Rasterizer, scene: &Scene) {
    let Scene {
        objects,
        occluders,
        settings,
        ..
    } = *scene;
    let candidates = || {
        let within = light.sets.reach.intersection(&occluders.light);
        within.filter(|&object| {
            hides_from(light, objects, occluders, object) && !is_in_clearance(light, scene, object)
        })
    };
    if candidates().next().is_none() {
        viewpoint.clear();
        return;
    }
    let bounds = light.sets.reach.ones().fold(Aabb::EMPTY, |bounds, object| {
        bounds.union(objects.boxes.get(object))
    });
    let views = light_views(light, &bounds, settings.light_texels.clamp(16, 1024));
    viewpoint.draw(
        rasterizer,
        &views,
        candidates(),
        objects,
        occluders,
        settings,
        Blocks::Light,
    );
}
