//! The frame's maps: what each face shows, and which are drawn anew.
//!
//! A kept map has two layers. In the *still* layer stand all casters that the light reaches and that do not move,
//! whether or not their shadow can be seen: so it holds for any view. Casters that move stand in the *moving* layer,
//! which is drawn over a copy of the still one. A face is drawn anew only when something that it shows changed: each
//! has a revision, and the recorder draws those whose revision it has not drawn yet. A map that is not kept shows the
//! shadow set S, and is drawn every frame.

use bevy_ecs::prelude::*;

use super::face_state::{FaceState, Stale};
use super::light_map::LightMap;
use super::members::{Scene, expected_faces, farthest, fill_casters, lit_faces, split_members};
use super::movers::{Movers, Remap};
use super::plan::{Grant, Want, share_out, total_bytes};
use super::request::{MapRequest, MapShape};
use super::settings::{MapError, MapResolution, MapSettings};
use crate::scene::{SceneMaterials, SceneMesh};
use crate::sets::{FrameLights, Objects, View};
use crate::silhouettes::LightClearance;
use crate::techniques::{OmniMap, ShadowMap};

/// What is wrong with a light's map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapReport {
    /// The light.
    pub entity: Entity,
    /// What is wrong.
    pub error: MapError,
}

/// The maps of this frame. Written by [`build_maps`].
#[derive(Resource, Clone, Debug, Default)]
pub struct Maps {
    /// All lights with a usable map, ascending by light; those out of view too, for their maps are kept.
    pub lights: Vec<LightMap>,
    /// Lights whose map is refused, or less than was asked for; ascending by light.
    pub reports: Vec<MapReport>,
    /// Those that the frame before did not have.
    pub newly_reported: Vec<MapReport>,
    /// Bytes of the maps that are kept.
    pub bytes: u64,
    /// Faces of kept maps to be drawn anew in this frame.
    pub updated_faces: usize,
    /// Faces that changed and wait, for [`MapSettings::face_updates`] were used up.
    pub waiting_faces: usize,
    movers: Movers,
    frame: u64,
    revision: u64,
    previous: Vec<LightMap>,
    previous_reports: Vec<MapReport>,
    wants: Vec<Want>,
    grants: Vec<Grant>,
    order: Vec<usize>,
    candidates: Vec<Candidate>,
}

/// A face that may be drawn anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// It shows something, if not the latest.
    may_wait: bool,
    /// Inverted: the most visible comes first, and who waited gains with each frame, so that all are served.
    hidden: u64,
    light: usize,
    /// All faces, if `None`: they must show the light at one place.
    face: Option<usize>,
}

impl Maps {
    /// The map of a light of [`FrameLights`], if it has one that is looked up.
    pub fn of_light(&self, light: usize) -> Option<&LightMap> {
        let at = self.lights.binary_search_by_key(&light, |map| map.light).ok()?;
        Some(&self.lights[at]).filter(|map| map.active)
    }

    /// Lists the lights, each with its state of the frame before.
    fn collect_lights(
        &mut self,
        lights: &FrameLights,
        shadow_maps: &Query<&ShadowMap>,
        omni_maps: &Query<&OmniMap>,
    ) {
        std::mem::swap(&mut self.lights, &mut self.previous);
        self.lights.clear();
        std::mem::swap(&mut self.reports, &mut self.previous_reports);
        self.reports.clear();
        let mut old = self.previous.drain(..).peekable();
        for (index, light) in lights.lights.iter().enumerate() {
            let request = match (shadow_maps.get(light.entity), omni_maps.get(light.entity)) {
                (Ok(map), _) => MapRequest::of_shadow_map(map, &light.light),
                (_, Ok(map)) => MapRequest::of_omni_map(map, &light.light),
                _ => continue,
            };
            while old.next_if(|map| map.entity < light.entity).is_some() {}
            let known = old.next_if(|map| map.entity == light.entity);
            match request {
                Ok(request) => {
                    let mut map = known.unwrap_or_else(|| LightMap::new(light, request));
                    map.begin(index, light, request);
                    self.lights.push(map);
                }
                Err(error) => self.reports.push(MapReport {
                    entity: light.entity,
                    error,
                }),
            }
        }
    }

    /// Gives every map its resolution and says whether it is kept.
    fn share_memory(&mut self, settings: &MapSettings) {
        self.wants.clear();
        for map in &mut self.lights {
            let mut wanted = map.wanted_resolution();
            if wanted > settings.largest {
                let error = MapError::Largest {
                    wanted,
                    limit: settings.largest,
                };
                self.reports.push(MapReport {
                    entity: map.entity,
                    error,
                });
                wanted = settings.largest.max(1);
            }
            let least = match map.request.resolution {
                MapResolution::Fixed(_) => 64,
                MapResolution::Auto { least, .. } => least,
            };
            self.wants.push(Want {
                bytes_per_square: 4 * u64::from(map.request.face_count()) * map.texture_count(),
                resolution: wanted,
                least: least.min(wanted),
                cached: map.request.cached,
                // In steps, so that small moves of the view exchange no maps.
                visibility: u64::from(map.visibility.checked_ilog2().map_or(0, |log| log + 1)),
            });
        }
        share_out(
            &self.wants,
            settings.memory_limit,
            &mut self.grants,
            &mut self.order,
        );
        self.bytes = total_bytes(&self.wants, &self.grants);
        for ((map, want), grant) in self.lights.iter_mut().zip(&self.wants).zip(&self.grants) {
            if (map.resolution, map.cached) != (grant.resolution, grant.cached) {
                map.forget();
                (map.resolution, map.cached) = (grant.resolution, grant.cached);
            }
            let given = grant.resolution;
            let error = match (want.cached, grant.cached) {
                (true, false) => MapError::Uncached { given },
                _ if given < want.resolution => MapError::Coarser {
                    wanted: want.resolution,
                    given,
                },
                _ => continue,
            };
            self.reports.push(MapReport {
                entity: map.entity,
                error,
            });
        }
        self.reports.sort_by_key(|report| report.entity);
        self.newly_reported.clear();
        for report in &self.reports {
            let kind = std::mem::discriminant(&report.error);
            let same =
                |old: &MapReport| old.entity == report.entity && std::mem::discriminant(&old.error) == kind;
            if !self.previous_reports.iter().any(same) {
                self.newly_reported.push(*report);
            }
        }
    }

    /// Lists the faces that show something else than they should.
    fn collect_candidates(&mut self, scene: &Scene, lights: &FrameLights) {
        self.candidates.clear();
        let now = self.frame;
        for (index, map) in self.lights.iter_mut().enumerate() {
            if !map.active {
                map.settled_at = None; // what moves meanwhile is not taken in
                continue;
            }
            let light = &lights.lights[map.light];
            if map.settled_at.is_some() {
                map.waited = 0;
            }
            let changed = fill_casters(&mut map.casters, scene.objects, light, map.cached);
            let unmoved = map.settled_at.is_some_and(|at| at >= self.movers.changed_at);
            if map.cached && unmoved && !changed {
                let key = map.face_key(light, scene, map.reach);
                if map.key == Some(key) {
                    map.settled_at = Some(now);
                    continue;
                }
            }
            map.reach = farthest(light, &map.casters, scene.objects);
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
                split_members(&map.casters, &face, scene.objects, lit, movers, still, moving);
                state.compare(&self.movers, map.cached);
            }
            let mut push = |face: Option<usize>, revision: u64| {
                self.candidates.push(Candidate {
                    may_wait: map.cached && revision != 0,
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

    /// Takes in what the budget allows, most visible lights first.
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

    /// Follows a new dense index.
    fn remap(&mut self, remap: &Remap) {
        for map in &mut self.lights {
            map.settled_at = None;
            map.casters = remap.apply(&map.casters).0;
            map.faces.iter_mut().for_each(|face| face.remap(remap));
        }
    }
}

/// Shares the memory for maps among the lights, finds what each face shows, and takes in what changed.
///
/// Set: `BuildTechniques`. Reads [`FrameLights`], [`Objects`], [`View`], the components of the lights; writes [`Maps`].
/// With nothing changed it compares keys, O(lights); a light whose casters changed costs O(casters × faces).
pub fn build_maps(
    mut maps: ResMut<Maps>,
    settings: Res<MapSettings>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    view: Res<View>,
    clearance: Res<LightClearance>,
    shadow_maps: Query<&ShadowMap>,
    omni_maps: Query<&OmniMap>,
    exchanged: Query<Entity, Or<(Changed<SceneMesh>, Changed<SceneMaterials>)>>,
) {
    let maps = &mut *maps;
    maps.frame += 1;
    let exchanged = exchanged.iter().filter_map(|entity| objects.index_of(entity));
    let remap = maps
        .movers
        .update(&objects, exchanged, maps.frame, settings.still_after);
    if let Some(remap) = remap {
        maps.remap(&remap);
    }
    maps.collect_lights(&lights, &shadow_maps, &omni_maps);
    let Some(data) = &view.data else {
        for map in &mut maps.lights {
            map.active = false;
        }
        return;
    };
    maps.share_memory(&settings);
    let scene = Scene {
        objects: &objects,
        view: data,
        view_generation: view.generation,
        near_share: clearance.share().max(1e-7), // a perspective needs some near plane
    };
    maps.collect_candidates(&scene, &lights);
    maps.take_in(settings.face_updates);
}
