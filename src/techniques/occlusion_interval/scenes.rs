//! The maps that the lights of a frame use.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use smallvec::SmallVec;

use super::component::OcclusionInterval;
use super::fault::IntervalFault;
use super::intervals::{Window, seen_share, shining};
use super::library::{IntervalFolder, IntervalLibrary};
use super::maps::IntervalMaps;
use super::matching::{IntervalScene, MeshHashes, Meshes};
use crate::scene::{FaceCulling, LightKind, LightPath, SceneMaterials, SceneMesh};
use crate::sets::{FrameLights, Objects};

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
    /// Share of the window in which the light shines at all: the most that objects which are not in the maps see of it. The sun does
    /// not shine below the horizon.
    pub shining: f32,
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
    /// Layout of the objects when unused hashes were forgotten.
    layout: u64,
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

/// Reads the maps of lights that are new, and finds their surfaces in the world.
///
/// Set: [`LeavingSystems`](crate::techniques::LeavingSystems). Reads [`FrameLights`], [`Objects`], [`LightPath`],
/// [`IntervalFolder`], [`FaceCulling`] and the settings; writes [`IntervalLibrary`] and [`IntervalScenes`]. Meshes are hashed
/// when objects come or go. Surfaces are looked for again when a material is exchanged, too. A frame in which nothing moves
/// compares nothing; one in which something does compares the maps' surfaces with what moved.
pub fn match_interval_maps(
    mut scenes: ResMut<IntervalScenes>,
    mut library: ResMut<IntervalLibrary>,
    folder: Res<IntervalFolder>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    settings: Query<(&OcclusionInterval, Option<&LightPath>)>,
    meshes: Meshes,
    culling: Res<FaceCulling>,
    changed: Query<(), Or<(Changed<SceneMesh>, Changed<SceneMaterials>)>>,
) {
    let scenes = &mut *scenes;
    let library = library.bypass_change_detection();
    scenes.list_lights(library, &folder, &lights, &settings);
    library.end_frame(|name| settings.iter().any(|(settings, _)| settings.maps == name));
    let objects_changed = !changed.is_empty();
    let IntervalScenes {
        scenes: all,
        hashes,
        generation,
        layout,
        ..
    } = scenes;
    for scene in all.iter_mut() {
        if scene.is_stale(&objects, &meshes, (*culling, objects_changed))
            && scene.find(&objects, &meshes, *culling, hashes)
        {
            *generation += 1;
            scene.generation = *generation;
        }
    }
    if objects_changed || *layout != objects.layout_generation {
        *layout = objects.layout_generation;
        hashes.forget_unused();
    }
    scenes.refuse_other_scenes();
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

/// The share of a window of time in which a light shines at all.
fn shining_share(path: Option<&LightPath>, time: f32, width: f32) -> f32 {
    match path {
        Some(path) if path.check().is_ok() => {
            let window = Window::new(path.time(time), width, path.is_closed());
            seen_share(&shining(path), &window)
        }
        _ => 1.0,
    }
}

impl IntervalScenes {
    /// Lists the lights of the frame that maps shadow, and the scenes of those maps.
    fn list_lights(
        &mut self,
        library: &mut IntervalLibrary,
        folder: &IntervalFolder,
        lights: &FrameLights,
        settings: &Query<(&OcclusionInterval, Option<&LightPath>)>,
    ) {
        self.lights.clear();
        for scene in &mut self.scenes {
            scene.is_used = false;
            scene.payer = None;
        }
        for (index, light) in lights.lights.iter().enumerate() {
            if !light.is_shadowed_by::<OcclusionInterval>() {
                continue;
            }
            let Ok((settings, path)) = settings.get(light.entity) else {
                continue;
            };
            library.read(&settings.maps, folder);
            let scene = match library.get(&settings.maps) {
                Some(Ok(maps)) => check_light(maps, path, light.light.kind)
                    .map(|()| self.scene(maps, light.selection.casts_for)),
                Some(Err(error)) => Err(IntervalFault::Maps(error.to_owned())),
                None => continue,
            };
            let (time, shining) = match &scene {
                Ok(scene) => {
                    let scene = &self.scenes[*scene];
                    let window = scene.maps.window(settings.time, settings.width);
                    let shining = seen_share(&scene.shining, &window);
                    (scene.maps.path.time(settings.time), shining)
                }
                Err(_) => (settings.time, shining_share(path, settings.time, settings.width)),
            };
            self.lights.push(IntervalLight {
                light: index,
                entity: light.entity,
                scene,
                time,
                width: settings.width,
                shining,
            });
        }
        self.forget_unused();
    }

    /// Takes the maps from lights whose scene is another one.
    fn refuse_other_scenes(&mut self) {
        for light in &mut self.lights {
            let Ok(index) = light.scene else { continue };
            let scene = &self.scenes[index];
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

    /// Chooses the light that asks for the memory of each scene's textures.
    pub(super) fn choose_payers(&mut self, lights: &FrameLights) {
        let area = |light: usize| {
            let scissor = lights.lights.get(light).and_then(|light| light.region.scissor);
            scissor.map_or(0, |scissor| scissor.area())
        };
        for light in &self.lights {
            let Ok(index) = light.scene else { continue };
            let payer = &mut self.scenes[index].payer;
            if payer.is_none_or(|payer| area(payer) < area(light.light)) {
                *payer = Some(light.light);
            }
        }
    }
}

impl IntervalScenes {
    /// The index of the scene of some maps and of a mask of casters. It is made if it is new.
    fn scene(&mut self, maps: &Arc<IntervalMaps>, casts_for: u32) -> usize {
        let known = self
            .scenes
            .iter()
            .position(|scene| scene.casts_for == casts_for && Arc::ptr_eq(&scene.maps, maps));
        let index = known.unwrap_or_else(|| {
            self.scenes.push(IntervalScene::new(maps, casts_for));
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
