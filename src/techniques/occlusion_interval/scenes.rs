//! Finds the surfaces of maps among the objects of the world.

use std::collections::HashMap;
use std::sync::Arc;

use bevy_ecs::prelude::*;
use smallvec::SmallVec;

use super::component::OcclusionInterval;
use super::library::IntervalLibrary;
use super::maps::IntervalMaps;
use super::surface::{is_same_place, surface_hash};
use crate::scene::placement::Placement;
use crate::scene::{LightKind, LightPath, MeshData, PathError, SceneMesh};
use crate::sets::{FrameLights, Objects};

/// Why a light's maps are not used. The light then shines without a shadow.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IntervalFault {
    /// The maps cannot be read.
    #[error("its maps cannot be read: {0}")]
    Maps(String),
    /// The path of the light cannot be used.
    #[error("its path cannot be used: {0}")]
    Path(PathError),
    /// The maps are those of another path.
    #[error("its maps were baked for another path; bake them again")]
    OtherPath,
    /// The path moves a light of another kind.
    #[error("the path of its maps is that of a {0} light")]
    OtherKind(&'static str),
    /// Surfaces that were baked are not in the scene.
    #[error(
        "{missing} of the {all} surfaces in its maps are not in the scene, or stand elsewhere, the first being mesh \"{first}\"; bake the maps again"
    )]
    OtherScene {
        /// Number of surfaces that are missing.
        missing: usize,
        /// Number of surfaces in the maps.
        all: usize,
        /// Name of the first missing mesh.
        first: String,
    },
}

impl IntervalFault {
    /// Number of the fault in reports.
    pub(super) fn code(&self) -> u32 {
        match self {
            Self::Maps(_) => 1,
            Self::Path(_) => 2,
            Self::OtherPath => 3,
            Self::OtherKind(_) => 4,
            Self::OtherScene { .. } => 5,
        }
    }
}

/// A surface of the maps and the object that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MatchedSurface {
    /// Entity of the object.
    pub entity: Entity,
    /// Dense index of the object.
    pub object: u32,
    /// Index of the submesh.
    pub submesh: u32,
    /// Index in [`IntervalMaps::surfaces`].
    pub surface: u32,
}

/// The surfaces of one set of maps in the world.
#[derive(Clone, Debug)]
pub struct IntervalScene {
    /// The maps.
    pub maps: Arc<IntervalMaps>,
    /// The surfaces that were found, in the order of objects.
    pub matched: Vec<MatchedSurface>,
    /// Number of surfaces that were not found.
    pub missing: usize,
    /// Index of the first surface that was not found.
    pub first_missing: Option<usize>,
    /// Receivers of the world that are not in the maps.
    pub strangers: usize,
    /// Increases whenever `matched` may have changed.
    pub generation: u64,
    layout: Option<u64>,
    is_used: bool,
}

/// The maps of a light of the frame.
#[derive(Clone, Debug)]
pub struct IntervalLight {
    /// Index in [`FrameLights`].
    pub light: usize,
    /// Entity of the light.
    pub entity: Entity,
    /// Index in [`IntervalScenes::scenes`], or why there is none.
    pub scene: Result<usize, IntervalFault>,
    /// Time within the path.
    pub time: f32,
    /// Width of the window, as a share of the path.
    pub width: f32,
}

/// The lights of the frame that maps shadow, and the scenes of those maps. Written by `match_interval_maps`.
#[derive(Resource, Debug, Default)]
pub struct IntervalScenes {
    /// The scenes in use.
    pub scenes: Vec<IntervalScene>,
    /// The lights, in the order of [`FrameLights`].
    pub lights: Vec<IntervalLight>,
    hashes: MeshHashes,
    generation: u64,
}

impl IntervalScenes {
    /// The maps of a light of the frame; `None` if this technique does not shadow it.
    pub fn of_light(&self, light: usize) -> Option<&IntervalLight> {
        let at = self
            .lights
            .binary_search_by_key(&light, |light| light.light)
            .ok()?;
        Some(&self.lights[at])
    }

    /// The scene of a light of the frame; `None` if it has no usable maps.
    pub fn scene_of(&self, light: usize) -> Option<&IntervalScene> {
        let scene = self.of_light(light)?.scene.as_ref().ok()?;
        self.scenes.get(*scene)
    }
}

/// Hashes of meshes by the address of their data, which the entry keeps alive.
#[derive(Debug, Default)]
struct MeshHashes(HashMap<usize, (Arc<MeshData>, SmallVec<[u64; 2]>)>);

impl MeshHashes {
    fn of(&mut self, mesh: &Arc<MeshData>) -> &[u64] {
        let entry = self.0.entry(Arc::as_ptr(mesh) as usize).or_insert_with(|| {
            let hashes = mesh.submeshes.iter().map(|submesh| surface_hash(mesh, submesh));
            (mesh.clone(), hashes.collect())
        });
        &entry.1
    }

    /// Forgets meshes that nobody else holds.
    fn forget_unused(&mut self) {
        self.0.retain(|_, (mesh, _)| Arc::strong_count(mesh) > 1);
    }
}

type Meshes<'w, 's> = Query<'w, 's, (&'static SceneMesh, Placement)>;

/// Reads the maps of lights that are new, and finds their surfaces in the world.
///
/// Set: `BuildTechniques`, before memory for textures is asked for. Reads [`FrameLights`], [`Objects`], [`LightPath`] and
/// the settings; writes [`IntervalLibrary`] and [`IntervalScenes`]. Meshes are hashed when objects come or go. A frame in
/// which nothing moves compares nothing; one in which something does compares the maps' surfaces with what moved.
pub fn match_interval_maps(
    mut scenes: ResMut<IntervalScenes>,
    mut library: ResMut<IntervalLibrary>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    settings: Query<(&OcclusionInterval, Option<&LightPath>)>,
    meshes: Meshes,
    changed: Query<(), Changed<SceneMesh>>,
) {
    let scenes = &mut *scenes;
    scenes.lights.clear();
    for scene in &mut scenes.scenes {
        scene.is_used = false;
    }
    let library = library.bypass_change_detection();
    for (index, light) in lights.lights.iter().enumerate() {
        if !light.is_shadowed_by::<OcclusionInterval>() {
            continue;
        }
        let Ok((settings, path)) = settings.get(light.entity) else {
            continue;
        };
        library.read(&settings.maps);
        let scene = match library.get(&settings.maps) {
            Some(Ok(maps)) => check_light(maps, path, light.light.kind).map(|()| scenes.scene(maps)),
            Some(Err(error)) => Err(IntervalFault::Maps(error.to_owned())),
            None => continue,
        };
        let time = match &scene {
            Ok(scene) => scenes.scenes[*scene].maps.path.time(settings.time),
            Err(_) => settings.time,
        };
        scenes.lights.push(IntervalLight {
            light: index,
            entity: light.entity,
            scene,
            time,
            width: settings.width,
        });
    }
    scenes.forget_unused();
    if scenes.scenes.is_empty() {
        return;
    }
    let meshes_changed = !changed.is_empty();
    let IntervalScenes {
        scenes: all,
        hashes,
        generation,
        ..
    } = scenes;
    for scene in all.iter_mut() {
        if scene.is_stale(&objects, &meshes, meshes_changed) {
            *generation += 1;
            scene.generation = *generation;
            scene.find(&objects, &meshes, hashes);
        }
    }
    if meshes_changed {
        hashes.forget_unused();
    }
    refuse_other_scenes(scenes);
}

fn check_light(maps: &IntervalMaps, path: Option<&LightPath>, kind: LightKind) -> Result<(), IntervalFault> {
    if let Some(path) = path {
        path.check().map_err(IntervalFault::Path)?;
        if *path != maps.path {
            return Err(IntervalFault::OtherPath);
        }
    }
    maps.path.check().map_err(IntervalFault::Path)?;
    match (maps.path.is_directional(), kind == LightKind::Directional) {
        (true, false) => Err(IntervalFault::OtherKind("directional")),
        (false, true) => Err(IntervalFault::OtherKind("point or spot")),
        _ => Ok(()),
    }
}

/// Takes the maps from lights whose scene is another one.
fn refuse_other_scenes(scenes: &mut IntervalScenes) {
    for light in &mut scenes.lights {
        let Ok(index) = light.scene else { continue };
        let scene = &scenes.scenes[index];
        if scene.missing > 0 {
            let first = scene.first_missing.and_then(|at| scene.maps.surfaces.get(at));
            light.scene = Err(IntervalFault::OtherScene {
                missing: scene.missing,
                all: scene.maps.surfaces.len(),
                first: first.map(|surface| surface.mesh.clone()).unwrap_or_default(),
            });
        }
    }
}

impl IntervalScenes {
    /// The index of the scene of some maps, which is made if it is new.
    fn scene(&mut self, maps: &Arc<IntervalMaps>) -> usize {
        let known = self
            .scenes
            .iter()
            .position(|scene| Arc::ptr_eq(&scene.maps, maps));
        let index = known.unwrap_or_else(|| {
            self.scenes.push(IntervalScene {
                maps: maps.clone(),
                matched: Vec::new(),
                missing: maps.surfaces.len(),
                first_missing: None,
                strangers: 0,
                generation: 0,
                layout: None,
                is_used: true,
            });
            self.scenes.len() - 1
        });
        self.scenes[index].is_used = true;
        index
    }

    /// Drops scenes that no light uses. Indices of lights follow.
    fn forget_unused(&mut self) {
        if self.scenes.iter().all(|scene| scene.is_used) {
            return;
        }
        let mut kept = 0;
        let moved: SmallVec<[usize; 8]> = self
            .scenes
            .iter()
            .map(|scene| {
                let at = kept;
                kept += usize::from(scene.is_used);
                at
            })
            .collect();
        self.scenes.retain(|scene| scene.is_used);
        for light in &mut self.lights {
            if let Ok(scene) = &mut light.scene {
                *scene = moved[*scene];
            }
        }
    }
}

impl IntervalScene {
    /// Whether the surfaces must be looked for again.
    fn is_stale(&self, objects: &Objects, meshes: &Meshes, meshes_changed: bool) -> bool {
        if self.layout != Some(objects.layout_generation) || meshes_changed {
            return true;
        }
        if !objects.any_moved() {
            return false;
        }
        let has_left = |matched: &MatchedSurface| {
            objects.moved.contains(matched.object as usize) && {
                let baked = &self.maps.surfaces[matched.surface as usize];
                let place = meshes.get(matched.entity).ok();
                let place = place.and_then(|(_, place)| place.exact_affine());
                !place.is_some_and(|place| is_same_place(&baked.world_from_local, &place))
            }
        };
        // What is missing may have come back.
        self.missing > 0 || self.matched.iter().any(has_left)
    }

    fn find(&mut self, objects: &Objects, meshes: &Meshes, hashes: &mut MeshHashes) {
        self.layout = Some(objects.layout_generation);
        self.matched.clear();
        self.strangers = 0;
        let mut by_hash: HashMap<u64, SmallVec<[u32; 2]>> = HashMap::new();
        for (index, surface) in self.maps.surfaces.iter().enumerate() {
            by_hash.entry(surface.hash).or_default().push(index as u32);
        }
        let mut is_found = vec![false; self.maps.surfaces.len()];
        for (object, &entity) in objects.entities.iter().enumerate() {
            let Ok((mesh, place)) = meshes.get(entity) else {
                continue;
            };
            let Some(place) = place.exact_affine() else {
                continue;
            };
            let mut is_stranger = false;
            for (submesh, hash) in hashes.of(&mesh.0).iter().enumerate() {
                let candidates = by_hash.get(hash).map_or(&[][..], |found| found);
                let here =
                    |&&at: &&u32| is_same_place(&self.maps.surfaces[at as usize].world_from_local, &place);
                // Two equal surfaces at one place see the same.
                let fresh = candidates.iter().filter(here).find(|&&at| !is_found[at as usize]);
                let Some(&surface) = fresh.or_else(|| candidates.iter().find(here)) else {
                    is_stranger = true;
                    continue;
                };
                is_found[surface as usize] = true;
                self.matched.push(MatchedSurface {
                    entity,
                    object: object as u32,
                    submesh: submesh as u32,
                    surface,
                });
            }
            self.strangers += usize::from(is_stranger && objects.receivers.contains(object));
        }
        self.missing = is_found.iter().filter(|found| !**found).count();
        self.first_missing = is_found.iter().position(|found| !found);
    }
}
