//! The draws of one light: the triangles of the maps that it lights, that show its shadows, and whose visibility the cleared
//! mask does not hold already.
//!
//! A pass over dense meshes costs as much as the light itself, and in a window of time most triangles are wholly lit or wholly
//! dark. So runs of triangles that would write the clear value everywhere are left out. The clear value is 1, or 0 if that
//! leaves fewer triangles and no surface is shown that is not in the maps.
//!
//! Two triangles may lie in exactly the same place. If both are drawn, the mask holds what the later one writes. If one of
//! them is left out, the mask holds what the other one writes.

use std::ops::Range;

use bevy_ecs::prelude::*;

use super::gpu_maps::{GpuMaps, GpuSurface};
use super::pipelines::Key;
use super::runs::LeftOut;
use crate::render::recorder::PrepareInput;
use crate::scene::FaceCulling;
use crate::sets::{FrameLight, FrameLights, Objects};
use crate::techniques::occlusion_interval::matching::IntervalScene;
use crate::techniques::occlusion_interval::scenes::{IntervalLight, IntervalScenes};
use crate::techniques::occlusion_interval::steps::Steps;

/// One draw: triangles of one object.
#[derive(Clone, Debug)]
pub struct Draw {
    /// The pipeline.
    pub key: Key,
    /// Range of [`GpuMaps::indices`].
    pub indices: Range<u32>,
    /// Index among the instances of the frame.
    pub instance: u32,
}

/// The draws of one light.
#[derive(Clone, Debug)]
pub struct LightPlan {
    /// Index of the light in [`FrameLights`].
    pub light: usize,
    /// Index of the maps in the recorder; `None` if the light shows no shadow.
    pub maps: Option<usize>,
    /// Visibility where nothing is drawn.
    pub clear: f32,
    /// Range of [`Draws::draws`].
    pub draws: Range<usize>,
    /// Index of the window among the constants.
    pub window: usize,
}

/// The draws of a frame. Their memory is kept.
#[derive(Debug, Default)]
pub struct Draws {
    /// The lights.
    pub lights: Vec<LightPlan>,
    /// The draws of all lights.
    pub draws: Vec<Draw>,
    /// The dense object index of each instance.
    pub objects: Vec<u32>,
    /// The keys of all surfaces that show shadows in the frame, drawn or left out. A window of another time needs no other
    /// pipelines.
    pub keys: Vec<Key>,
    /// Indices of the surfaces of the current light and dense indices of their objects.
    shown: Vec<(usize, u32)>,
}

/// Says of objects whether they show the shadows of a light.
struct Shows<'a> {
    light: &'a FrameLight,
    objects: &'a Objects,
    input: &'a PrepareInput<'a>,
}

impl Shows<'_> {
    fn handedness(&self, object: u32) -> f32 {
        let handedness = &self.input.table.handedness;
        handedness.get(object as usize).copied().unwrap_or(0.0)
    }

    fn on(&self, object: u32) -> bool {
        let at = object as usize;
        self.light.sets.i.contains(at)
            && self.objects.receivers.contains(at)
            && self.objects.layers[at] & self.light.selection.shows_on != 0
            && self.handedness(object) != 0.0
    }
}

impl Draws {
    /// Removes the last frame's draws.
    pub fn clear(&mut self) {
        self.lights.clear();
        self.draws.clear();
        self.objects.clear();
        self.keys.clear();
    }

    /// Plans the draws of one light. `maps` are its maps and their index.
    pub fn plan_light(
        &mut self,
        world: &World,
        input: &PrepareInput,
        planned: &IntervalLight,
        maps: Option<(usize, &GpuMaps)>,
    ) {
        let (first, light) = (self.draws.len(), planned.light);
        let scene = world.resource::<IntervalScenes>().scene_of(light);
        let mut clear = planned.shining;
        if let (Some((_, maps)), Some(scene)) = (maps, scene) {
            let shows = Shows {
                light: &world.resource::<FrameLights>().lights[light],
                objects: world.resource::<Objects>(),
                input,
            };
            self.find_shown(&shows, maps, scene);
            let window = Steps::of_window(&maps.maps.window(planned.time, planned.width));
            let left_out = self.choose(&shows, maps, scene, (planned, &window));
            if left_out == LeftOut::Dark {
                clear = 0.0;
            }
            let culling = world.get_resource::<FaceCulling>().copied().unwrap_or_default();
            self.push_draws(&shows, maps, (left_out, &window), culling);
        }
        self.lights.push(LightPlan {
            light,
            maps: maps.map(|(index, _)| index),
            clear,
            draws: first..self.draws.len(),
            window: self.lights.len(),
        });
    }

    fn find_shown(&mut self, shows: &Shows, maps: &GpuMaps, scene: &IntervalScene) {
        let object_of = |surface: &GpuSurface| scene.objects.get(surface.matched as usize).copied();
        let surfaces = maps.surfaces.iter().enumerate();
        let shown = surfaces
            .filter_map(|(at, surface)| Some((at, object_of(surface).filter(|object| shows.on(*object))?)));
        self.shown.clear();
        self.shown.extend(shown);
    }

    fn choose(
        &self,
        shows: &Shows,
        maps: &GpuMaps,
        scene: &IntervalScene,
        (planned, window): (&IntervalLight, &Steps),
    ) -> LeftOut {
        let is_day = Steps::of(&scene.shining).contains(window);
        let is_all_drawn = || !scene.outside.iter().any(|object| shows.on(*object));
        let may = |left_out: LeftOut| match left_out {
            LeftOut::Lit => is_day,
            LeftOut::Dark => planned.shining == 0.0 || (!shows.input.is_hosted && is_all_drawn()),
            LeftOut::Nothing => true,
        };
        let runs = self
            .shown
            .iter()
            .flat_map(|(surface, _)| &maps.runs[maps.surfaces[*surface].runs.clone()]);
        LeftOut::choose(runs, window, may)
    }

    fn push_draws(
        &mut self,
        shows: &Shows,
        maps: &GpuMaps,
        (left_out, window): (LeftOut, &Steps),
        culling: FaceCulling,
    ) {
        let culls = culling == FaceCulling::SingleSided;
        for &(surface, object) in &self.shown {
            let surface = &maps.surfaces[surface];
            let key = Key {
                mirrored: (shows.handedness(object) < 0.0) != shows.input.mirrored_view,
                culled: culls && !surface.is_two_sided,
            };
            if !self.keys.contains(&key) {
                self.keys.push(key);
            }
            let (first, instance) = (self.draws.len(), self.objects.len() as u32);
            left_out.remaining(&maps.runs[surface.runs.clone()], window, |indices| {
                self.draws.push(Draw {
                    key,
                    indices,
                    instance,
                });
            });
            if first < self.draws.len() {
                self.objects.push(object);
            }
        }
    }
}
