//! The frame's maps: what each face shows, and which faces are drawn again.
//!
//! A kept map has two layers. The *still* layer holds all casters that the light reaches and that do not
//! move, whether or not their shadow is visible, so it is valid for any view. The *moving* layer is a copy of
//! the still one, with the moving casters drawn over it. A face is drawn again only when something that it
//! shows has changed. Each face has a revision, and the recorder draws the faces whose revision it has not
//! drawn yet. A map that is not kept holds the shadow set S and is drawn every frame.

use bevy_ecs::prelude::*;

use super::cascade_range::{cascade_range, pixels_of_texel};
use super::face_state::{FaceState, Stale};
use super::format_steps::coarse_distance;
use super::frame_scene::Scene;
use super::light_map::{LightMap, asker};
use super::map_error::{MapError, MapReport};
use super::members::{
    corner_rounding, expected_faces, farthest, fill_casters, lit_faces, near_plane, split_members,
};
use super::movers::{Movers, Remap};
use super::request::MapShape;
use super::settings::{MapFormat, MapResolution, MapSettings};
use crate::sets::{FrameLights, Objects, View};
use crate::techniques::shared::texture_memory::TextureMemory;

/// Number of pixels along a side of a texel from which on a shadow is reported as coarse. An edge is then a staircase whose
/// steps are as large as small objects. By eye.
const COARSE_PIXELS: f64 = 64.0;

/// The maps of this frame. Written by [`ask_for_maps`](super::ask_for_maps()) and [`build_maps`].
#[derive(Resource, Clone, Debug, Default)]
pub struct Maps {
    /// All lights with a usable map, ascending by light. They include lights out of view, because their maps
    /// are kept.
    pub lights: Vec<LightMap>,
    /// Lights whose map is less than was asked for, though memory is not short; ascending by light.
    pub reports: Vec<MapReport>,
    /// Memory of the maps that are kept, bytes.
    pub bytes: u64,
    /// Number of faces of kept maps that are drawn again in this frame.
    pub updated_faces: usize,
    /// Number of faces that changed but wait, because [`MapSettings::face_updates`] is used up.
    pub waiting_faces: usize,
    pub(super) movers: Movers,
    pub(super) frame: u64,
    pub(super) previous: Vec<LightMap>,
    revision: u64,
    candidates: Vec<Candidate>,
}

/// A face, or all faces of a light, that may be drawn again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Whether the face shows something, though not the latest.
    may_wait: bool,
    /// Sort key, lowest first: the inverse of how visible the light is. A light gains with each frame that it
    /// waits, so all are served.
    hidden: u64,
    light: usize,
    /// The face; `None` stands for all faces, which must show the light at one position.
    face: Option<usize>,
}

impl Maps {
    /// Returns the map of a light of [`FrameLights`], if it is looked up in this frame.
    pub fn of_light(&self, light: usize) -> Option<&LightMap> {
        let at = self.lights.binary_search_by_key(&light, |map| map.light).ok()?;
        Some(&self.lights[at]).filter(|map| map.active)
    }

    /// Takes over the resolution of every map, and whether it is kept.
    fn take_grants(&mut self, lights: &FrameLights, memory: &TextureMemory) {
        self.bytes = 0;
        for map in &mut self.lights {
            // Every map has asked, and gets shared textures if there is no room for its own.
            let Some(grant) = memory.grant(map.light, asker(&lights.lights[map.light])) else {
                map.active = false;
                continue;
            };
            if (map.resolution, map.cached) != (grant.resolution, grant.is_own) {
                map.forget();
                (map.resolution, map.cached) = (grant.resolution, grant.is_own);
            }
            if map.cached {
                self.bytes += map.bytes_per_square() * u64::from(map.resolution).pow(2);
            }
        }
    }

    /// Lists the faces whose picture is out of date.
    fn collect_candidates(&mut self, scene: &Scene, lights: &FrameLights) {
        self.candidates.clear();
        let now = self.frame;
        for (index, map) in self.lights.iter_mut().enumerate() {
            if !map.active {
                map.settled_at = None; // its casters may move unnoticed meanwhile
                continue;
            }
            let light = &lights.lights[map.light];
            if map.settled_at.is_some() {
                map.waited = 0;
            }
            let unmoved = map.settled_at.is_some_and(|at| at >= self.movers.changed_at);
            let at_rest = map.cached && unmoved && !light.moved;
            // The light's sets are those of the last frame, so its casters need not be listed again.
            let same_sets = at_rest && map.settled_at == Some(now - 1) && !light.is_recomputed();
            let changed = !same_sets && fill_casters(&mut map.casters, scene.objects, light, map.cached);
            if at_rest && !changed {
                let key = map.face_key(light, scene, map.reach);
                if map.key == Some(key) {
                    map.settled_at = Some(now);
                    continue;
                }
            }
            let reach = farthest(light, map.casters.ones(), scene.objects);
            // The lookup scales all faces by one reach.
            if map.reach != reach && map.request.format != MapFormat::Depth {
                map.forget();
            }
            map.reach = reach;
            map.near = map.request.near.map_or_else(
                || near_plane(light, map.casters.ones(), scene.objects, map.reach).metres,
                f64::from,
            );
            let place = match light.point_world.w {
                0.0 => scene.view.eye,
                _ => light.point_world.truncate(),
            };
            map.rounding = corner_rounding(place, map.casters.ones(), scene.objects);
            if map.request.shape == MapShape::Cascades {
                let distance = f64::from(map.request.cascades.distance);
                let softness = f64::from(map.request.filter.softness().unwrap_or(0.0));
                map.range = cascade_range(light, scene.objects, scene.view, distance, softness);
            }
            map.key = Some(map.face_key(light, scene, map.reach));
            map.settled_at = Some(now);
            let expected = expected_faces(map, light, scene);
            let mut moved = false;
            let lit_faces = lit_faces(light);
            map.faces.truncate(expected.len());
            for (index, &face) in expected.iter().enumerate() {
                if map.faces.len() == index {
                    map.faces.push(FaceState::new(face));
                }
                let state = &mut map.faces[index];
                moved |= state.face != face;
                state.next.face = face;
                let (still, moving) = (&mut state.next.still, &mut state.next.moving);
                let movers = map.cached.then_some(&self.movers);
                let lit = map.request.shape != MapShape::Cube || lit_faces[index];
                let beside = map.request.beside.as_ref();
                split_members(
                    &map.casters,
                    beside,
                    &face,
                    scene.objects,
                    lit,
                    movers,
                    still,
                    moving,
                );
                state.compare(&self.movers, map.cached);
            }
            let mut push = |face: Option<usize>, revision: u64| {
                self.candidates.push(Candidate {
                    // Faces that follow the view may show nothing of what a late picture has.
                    may_wait: map.cached && revision != 0 && map.request.shape != MapShape::Matrices,
                    hidden: u64::MAX - map.visibility.saturating_mul(1 + map.waited),
                    light: index,
                    face,
                });
            };
            if moved && map.request.shape != MapShape::Cascades {
                push(
                    None,
                    map.faces.iter().map(|face| face.revision).min().unwrap_or(0),
                );
                continue;
            }
            for (face, state) in map.faces.iter().enumerate() {
                if state.next.stale > Stale::Nothing {
                    push(Some(face), state.revision);
                }
            }
        }
    }

    /// Reports the lights whose shadow is much coarser than the picture, or than the distance of what is shadowed.
    fn report_coarse(&mut self, scene: &Scene, lights: &FrameLights) {
        for map in self.lights.iter().filter(|map| map.active) {
            let pixels = match (map.request.shape, map.request.resolution) {
                (MapShape::Cascades, _) => pixels_of_texel(map, &map.range, scene.view),
                (MapShape::Matrices, _) => 0.0, // the technique that made the faces knows their texels
                (_, MapResolution::Auto { .. }) => map.needed / f64::from(map.resolution.max(1)),
                (_, MapResolution::Fixed(_)) => 0.0, // as it was asked for
            };
            if pixels > COARSE_PIXELS {
                self.reports.push(MapReport {
                    entity: map.entity,
                    error: MapError::Coarse {
                        pixels: pixels.round() as u32,
                    },
                });
            }
            if let Some(metres) = coarse_distance(map, &lights.lights[map.light]) {
                self.reports.push(MapReport {
                    entity: map.entity,
                    error: MapError::Steps {
                        centimetres: (metres * 100.0).round() as u32,
                    },
                });
            }
        }
        self.reports.sort_by_key(|report| report.entity);
    }

    /// Updates as many faces as the budget allows, most visible lights first.
    fn take_in(&mut self, budget: u32) {
        (self.updated_faces, self.waiting_faces) = (0, 0);
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.sort_unstable();
        for candidate in &candidates {
            let map = &mut self.lights[candidate.light];
            let range = candidate.face.map_or(0..map.faces.len(), |face| face..face + 1);
            let count = range.len();
            if candidate.may_wait && self.updated_faces + count > budget as usize && self.updated_faces > 0 {
                self.waiting_faces += count;
                map.waited += u64::from(map.settled_at.take().is_some());
                continue;
            }
            if map.cached {
                self.updated_faces += count;
            }
            for face in &mut map.faces[range] {
                face.take_in(
                    map.cached,
                    self.frame,
                    &mut self.revision,
                    candidate.face.is_none(),
                );
            }
        }
        self.candidates = candidates;
    }

    /// Applies a change of the dense indices.
    pub(super) fn remap(&mut self, remap: &Remap) {
        for map in &mut self.lights {
            map.settled_at = None;
            map.casters = remap.apply(&map.casters).0;
            map.faces.iter_mut().for_each(|face| face.remap(remap));
        }
    }
}

/// Finds what each face shows, and selects the faces to draw again.
///
/// Set: `BuildTechniques`, in [`TextureMemorySystems::Build`](crate::techniques::TextureMemorySystems::Build). Reads
/// [`FrameLights`], [`Objects`], [`View`] and [`TextureMemory`]; writes [`Maps`]. Cost: O(lights) comparisons if nothing
/// changed; the words of set L for a light with a kept map whose sets were computed again; O(casters × faces) for a light whose
/// casters changed, and for one without a kept map.
pub fn build_maps(
    mut maps: ResMut<Maps>,
    memory: Res<TextureMemory>,
    settings: Res<MapSettings>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    view: Res<View>,
) {
    let maps = &mut *maps;
    let Some(data) = &view.data else {
        return;
    };
    maps.take_grants(&lights, &memory);
    let scene = Scene {
        objects: &objects,
        view: data,
        view_generation: view.generation,
    };
    maps.collect_candidates(&scene, &lights);
    maps.take_in(settings.face_updates);
    maps.report_coarse(&scene, &lights);
}
