//! The lights that have a map in this frame, and the textures that their maps need.

use bevy_ecs::prelude::*;

use super::build_maps::Maps;
use super::light_map::{LightMap, asker};
use super::map_error::{MapError, MapReport};
use super::request::MapRequests;
use super::settings::{MapResolution, MapSettings};
use crate::scene::SceneMaterials;
use crate::sets::{FrameLights, Objects, View, ViewData};
use crate::techniques::shared::exchanged::Exchanged;
use crate::techniques::shared::texture_memory::{Storage, TextureMemory, TextureWant};

impl Maps {
    /// Lists the lights, each with its state of the last frame.
    fn collect_lights(&mut self, lights: &FrameLights, view: Option<&ViewData>, requests: &mut MapRequests) {
        std::mem::swap(&mut self.lights, &mut self.previous);
        self.lights.clear();
        self.reports.clear();
        let mut old = self.previous.drain(..).peekable();
        for asked in requests.drain() {
            let light = &lights.lights[asked.light];
            while old.next_if(|map| map.entity < light.entity).is_some() {}
            let known = old.next_if(|map| map.entity == light.entity);
            let mut map = known.unwrap_or_else(|| LightMap::new(light, asked.request));
            map.begin(asked, light, view);
            self.lights.push(map);
        }
    }

    /// Asks for the textures of every map.
    fn ask(&mut self, settings: &MapSettings, lights: &FrameLights, memory: &mut TextureMemory) {
        for map in &self.lights {
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
            let want = TextureWant {
                bytes_per_square: map.bytes_per_square(),
                resolution: wanted,
                least: least.min(wanted),
                storage: if map.request.cached {
                    Storage::OwnElseShared
                } else {
                    Storage::Shared
                },
            };
            memory.ask(map.light, asker(&lights.lights[map.light]), want);
        }
    }
}

/// Lists the lights with maps, and asks for the textures of their maps.
///
/// Set: `BuildTechniques`, in [`TextureMemorySystems::Ask`](crate::techniques::TextureMemorySystems::Ask). Reads
/// `MapRequests`, [`FrameLights`], [`Objects`] and [`View`]; writes [`Maps`] and [`TextureMemory`]. Cost: O(lights log
/// lights), and O(objects) where some moved.
pub fn ask_for_maps(
    mut maps: ResMut<Maps>,
    mut memory: ResMut<TextureMemory>,
    mut requests: ResMut<MapRequests>,
    settings: Res<MapSettings>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    view: Res<View>,
    exchanged: Exchanged,
    mut stripped: RemovedComponents<SceneMaterials>,
) {
    let maps = &mut *maps;
    maps.frame += 1;
    let exchanged = exchanged
        .iter()
        .chain(stripped.read())
        .filter_map(|entity| objects.index_of(entity));
    let remap = maps
        .movers
        .update(&objects, exchanged, maps.frame, settings.still_after);
    if let Some(remap) = remap {
        maps.remap(&remap);
    }
    maps.collect_lights(&lights, view.data.as_ref(), &mut requests);
    if view.data.is_some() {
        maps.ask(&settings, &lights, &mut memory);
    } else {
        maps.lights.iter_mut().for_each(|map| map.active = false);
    }
}
