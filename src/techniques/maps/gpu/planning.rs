//! Plans what a frame draws and looks up of each map: faces whose revision is not drawn yet, and the lights that share a
//! texture in turn.

use std::ops::Range;
use std::sync::atomic::Ordering;

use bevy_ecs::prelude::*;
use glam::{DMat4, DVec3};

use super::constants::{ending, map_constants};
use super::gpu_types::MapCaster;
use super::pipelines::{Key, Peel, filter_constant};
use super::plans::{FacePlan, LightPlan};
use super::pool::MapTexturesKey;
use super::recorder::MapNode;
use crate::render::RenderError;
use crate::render::recorder::PrepareInput;
use crate::sets::{FrameLights, Objects, View, ViewData};
use crate::techniques::maps::build_maps::Maps;
use crate::techniques::maps::face::FaceProjection;
use crate::techniques::maps::face_state::FaceState;
use crate::techniques::maps::light_map::LightMap;
use crate::techniques::maps::request::{MapRequest, MapShape};
use crate::techniques::maps::settings::{MapSettings, MapSurface};

impl MapNode {
    /// Plans the maps of the lights whose request is the recorder's own.
    ///
    /// # Errors
    /// Any error of the device or of a shader.
    pub(in crate::techniques) fn prepare_maps(
        &mut self,
        world: &World,
        input: &PrepareInput,
        is_own: impl Fn(&MapRequest) -> bool,
    ) -> Result<(), RenderError> {
        self.lights.clear();
        self.faces.clear();
        self.draws.clear();
        self.constants.constants.clear();
        let (Some(maps), Some(settings)) =
            (world.get_resource::<Maps>(), world.get_resource::<MapSettings>())
        else {
            return Ok(());
        };
        let Some(view) = world.get_resource::<View>().and_then(|view| view.data.as_ref()) else {
            return Ok(());
        };
        self.pool.begin();
        for map in maps.lights.iter().filter(|map| is_own(&map.request)) {
            if map.active {
                self.plan_light(world, input, map, view, settings.show_taps)?;
            } else if map.cached {
                let moving = map.has_moving();
                let key = MapTexturesKey::new(Some(map.entity), &map.request, map.resolution, moving);
                self.pool.keep(&key);
            }
        }
        self.pool.end();
        self.find_turns();
        let context = input.context;
        if self
            .casters
            .write(context, bytemuck::cast_slice(&self.draws.casters))
        {
            let layouts = &self.long_lived.layouts;
            self.caster_group = layouts.bind_casters(context, &self.casters.buffer);
        }
        if self.constants.write(context) {
            self.map_group = self.long_lived.bind_map(context, &self.constants);
        }
        Ok(())
    }

    /// Plans the draws of one face. Returns `None` if the face is up to date.
    fn plan_face(
        &mut self,
        world: &World,
        input: &PrepareInput,
        map: &LightMap,
        face: usize,
        key: &MapTexturesKey,
    ) -> Result<Option<FacePlan>, RenderError> {
        let objects = world.resource::<Objects>();
        let state: &FaceState = &map.faces[face];
        let Some(textures) = self.pool.get(key) else {
            return Ok(None);
        };
        let record = &textures.records[face];
        let has = |at: &std::sync::atomic::AtomicU64| at.load(Ordering::Relaxed);
        let draw_still = !map.cached || has(&record.still) != state.still_revision;
        let refresh = draw_still || has(&record.shown) != state.revision;
        if !refresh {
            return Ok(None);
        }
        let mut push = |set| self.draws.push(world, input, objects, &state.face, set);
        // A map that is not kept has one layer, which holds all casters.
        let own = if map.cached { &state.still } else { &state.moving };
        let still = draw_still.then(|| push(own));
        let moving = key.moving.then(|| push(&state.moving));
        let peeled = if map.request.surface == MapSurface::Nearest {
            [0..0, 0..0]
        } else {
            let over = moving.clone().unwrap_or(0..0);
            [still.clone().unwrap_or_else(|| push(own)), over]
        };
        let [first, second] = &peeled;
        let peel = match state.face.projection {
            FaceProjection::Parallel { .. } => Peel::Parallel,
            FaceProjection::Perspective { .. } | FaceProjection::Matrix { .. } => Peel::Perspective,
        };
        let ranges = [
            (still.as_ref(), Peel::No),
            (moving.as_ref(), Peel::No),
            (Some(first), peel),
            (Some(second), peel),
        ];
        for (range, peel) in ranges {
            for masked in self.draws.masked(range.cloned().unwrap_or(0..0)) {
                self.require(input.gpu, Key::Caster { masked, peel })?;
            }
        }
        Ok(Some(FacePlan {
            face,
            still,
            moving,
            peeled,
            peel,
            still_revision: state.still_revision,
            revision: state.revision,
        }))
    }

    /// Computes the matrices from each face's clip space to the view's, for the debug view.
    fn plan_frusta(
        &mut self,
        map: &LightMap,
        input: &PrepareInput,
        view: &ViewData,
    ) -> Result<Range<u32>, RenderError> {
        let first = self.draws.casters.len() as u32;
        if !input.debug_view {
            return Ok(first..first);
        }
        self.require(input.gpu, Key::Frustum)?;
        for state in &map.faces {
            // Reversed depth reaches infinity, where no edge would end. So perspective faces are cut at the
            // reach.
            let (far, length) = match state.face.projection {
                FaceProjection::Perspective { near, .. } => (near / map.reach, 0.5),
                FaceProjection::Matrix { parallel: false, .. } => {
                    let [x, y, z] = state.face.axes;
                    let clip = state.face.clip_from_relative(state.face.origin);
                    let far = clip * (z * map.reach + (x + y) * 1e-9).extend(1.0);
                    (far.z / far.w, 0.5)
                }
                FaceProjection::Parallel { .. } | FaceProjection::Matrix { .. } => (0.0, 1.0),
            };
            let cut =
                DMat4::from_translation(DVec3::Z * far) * DMat4::from_scale(DVec3::new(1.0, 1.0, length));
            let clip = view.clip_from_world * state.face.clip_from_world().inverse() * cut;
            self.draws.casters.push(MapCaster {
                clip_from_centered: clip.as_mat4().to_cols_array_2d(),
                center_local: [0.0; 4],
            });
        }
        Ok(first..self.draws.casters.len() as u32)
    }

    /// Finds the lights that use one texture in turn, because none of them keeps its map.
    fn find_turns(&mut self) {
        for at in 0..self.lights.len() {
            let key = self.lights[at].key;
            let shares = |(other, plan): (usize, &LightPlan)| other != at && plan.key == key;
            self.lights[at].takes_turns = key.entity.is_none() && self.lights.iter().enumerate().any(shares);
        }
    }

    fn plan_light(
        &mut self,
        world: &World,
        input: &PrepareInput,
        map: &LightMap,
        view: &ViewData,
        show_taps: bool,
    ) -> Result<(), RenderError> {
        let moving = map.has_moving();
        let key = MapTexturesKey::new(
            map.cached.then_some(map.entity),
            &map.request,
            map.resolution,
            moving,
        );
        self.pool.require(input.context, &self.long_lived.layouts, key);
        let first_face = self.faces.len();
        let first_draw = self.draws.draws.len();
        for face in 0..map.faces.len() {
            let plan = self.plan_face(world, input, map, face, &key)?;
            self.faces.extend(plan);
        }
        let request = map.request;
        let parallel = request.shape == MapShape::Cascades;
        if request.has_final() {
            let (format, surface) = (request.format, request.surface);
            let convert = Key::Convert {
                format,
                surface,
                parallel,
            };
            self.require(input.gpu, convert)?;
        }
        let lookup = (request.beside.is_none()).then_some(Key::Resolve {
            filter: filter_constant(request.filter),
            shape: request.shape,
            cascade_count: if parallel { request.face_count() } else { 1 },
            format: request.format,
            show_taps,
        });
        if let Some(lookup) = lookup {
            self.require(input.gpu, lookup)?;
        }
        let lights = world.resource::<FrameLights>();
        let bounds = lights.lights[map.light].region.depth_bounds;
        let bounds = bounds.map_or((1.0, 0.0), |bounds| (bounds.depth_max, bounds.depth_min));
        let mut constants = map_constants(map, view.eye, bounds);
        if parallel {
            constants.ending = ending(&request.cascades, view.frustum.shape().forward);
        }
        self.constants.constants.push(&constants);
        let draw_count = self.draws.draws.len() - first_draw;
        let frusta = self.plan_frusta(map, input, view)?;
        self.lights.push(LightPlan {
            light: map.light,
            request,
            key,
            lookup,
            faces: first_face..self.faces.len(),
            takes_turns: false,
            draw_count,
            frusta,
        });
        Ok(())
    }
}
