//! Draws the maps that changed and looks them up into the mask.
//!
//! Shaders `shaders/techniques/maps/{caster,convert,resolve}.wgsl`
//! Groups  casters: 0 casters, 1 first surface, 2 material; conversion: 1 surfaces, 2 map; lookup: 0 view, 1 receiver,
//!         2 map, 3 textures
//! Reads   receiver depth and plane.  Writes  the mask, inside the light's scissor
//! Order   after `depth copy` and `receiver plane`, before `light_accumulate` of the same light
//!
//! Faces are drawn by `draw_pictures`, once a frame, before any pass on the screen. The exception is a
//! texture that several lights use in turn, which is drawn just before each lookup. Lights whose maps are not
//! kept share textures of equal size and format.
//!
//! A face is drawn in steps. Still casters are drawn into their layer. The layer is copied, and moving
//! casters are drawn over the copy. Where the lookup needs more than the depth of the nearest surface, the
//! second surface is drawn and the depths are converted. A step is skipped while its revision is unchanged.

use std::sync::Arc;

use bevy_ecs::prelude::*;

use super::draws::MapDraws;
use super::gpu_types::MapLight;
use super::layouts::{MapLayouts, jitter_texture};
use super::pipelines::{FILES, Key, describe};
use super::plans::{FacePlan, LightPlan};
use super::pool::MapPool;
use super::recorded::Recorded;
use crate::render::gpu::buffers::GrowingBuffer;
use crate::render::gpu::pipeline_cache::Variants;
use crate::render::gpu::strided::StridedUniforms;
use crate::render::recorder::{
    Leaves, PictureInput, PrepareInput, RecordInput, Recorder, Resolve, ResolveInput,
};
use crate::render::{Gpu, RenderContext, RenderError};

/// The parts of the recorder that all views of a device share.
#[derive(Debug)]
pub(in crate::techniques) struct LongLived {
    pub layouts: MapLayouts,
    compare: wgpu::Sampler,
    jitter: wgpu::TextureView,
}

impl LongLived {
    fn new(gpu: &Gpu) -> Self {
        let device = &gpu.context.device;
        Self {
            layouts: MapLayouts::new(device),
            compare: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("map comparison"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                // Depth is reversed: a receiver is lit if its depth is not less than the map's.
                compare: Some(wgpu::CompareFunction::GreaterEqual),
                ..Default::default()
            }),
            jitter: jitter_texture(&gpu.context),
        }
    }

    pub(super) fn bind_map(
        &self,
        context: &RenderContext,
        maps: &StridedUniforms<MapLight>,
    ) -> wgpu::BindGroup {
        self.layouts
            .bind_map(context, maps.binding(), &self.compare, &self.jitter)
    }
}

/// The recorder of all maps.
#[derive(Debug)]
pub struct MapNode {
    pub(in crate::techniques) pipelines: Variants<Key>,
    pub(in crate::techniques) long_lived: Arc<LongLived>,
    pub(in crate::techniques) pool: MapPool,
    pub(in crate::techniques) draws: MapDraws,
    pub(super) casters: GrowingBuffer,
    pub(in crate::techniques) caster_group: wgpu::BindGroup,
    pub(super) constants: StridedUniforms<MapLight>,
    pub(in crate::techniques) map_group: wgpu::BindGroup,
    pub(in crate::techniques) lights: Vec<LightPlan>,
    pub(in crate::techniques) faces: Vec<FacePlan>,
}

impl MapNode {
    /// Compiles the shaders. Pipelines and textures are made when a frame needs them.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        gpu.compile(&FILES)?;
        let context = &gpu.context;
        let long_lived = gpu.part(LongLived::new);
        let casters = GrowingBuffer::new(context, "map casters", wgpu::BufferUsages::STORAGE);
        let constants = StridedUniforms::new(context, "maps");
        Ok(Self {
            pipelines: Variants::default(),
            caster_group: long_lived.layouts.bind_casters(context, &casters.buffer),
            map_group: long_lived.bind_map(context, &constants),
            pool: MapPool::new(context),
            draws: MapDraws::default(),
            lights: Vec::new(),
            faces: Vec::new(),
            long_lived,
            casters,
            constants,
        })
    }

    /// The slots and plans of the lights whose faces stay as they are drawn until they are looked up.
    pub(in crate::techniques) fn keepers(&self) -> impl Iterator<Item = (usize, &LightPlan)> {
        self.lights
            .iter()
            .enumerate()
            .filter(|(_, plan)| !plan.takes_turns)
    }

    pub(in crate::techniques) fn plan_of(&self, light: usize) -> Option<(usize, &LightPlan)> {
        let at = self.lights.binary_search_by_key(&light, |plan| plan.light).ok()?;
        Some((at, &self.lights[at]))
    }

    /// Requests a pipeline from the shared cache.
    pub(super) fn require(&mut self, gpu: &Gpu, key: Key) -> Result<(), RenderError> {
        let layouts = &self.long_lived.layouts;
        gpu.require(&mut self.pipelines, key, |gpu| describe(gpu, layouts, key))
    }
}

impl Resolve for MapNode {
    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        let Some((slot, plan)) = self.plan_of(light) else {
            return;
        };
        if plan.takes_turns {
            // Another light may have used the texture since, so the texture is drawn before each lookup.
            self.draw_faces(slot, plan, encoder, &input.pictures(), &mut Recorded::default());
        }
        self.look_up_light(slot, plan, encoder, input);
    }
}

impl MapNode {
    /// Looks up the map of one light, whose faces are drawn.
    pub(in crate::techniques) fn look_up_light(
        &self,
        slot: usize,
        plan: &LightPlan,
        encoder: &mut wgpu::CommandEncoder,
        input: &ResolveInput,
    ) {
        if let (Some(textures), Some(pipeline)) = (
            self.pool.get(&plan.key),
            plan.lookup.and_then(|key| self.pipelines.get(key)),
        ) {
            self.look_up(slot, &textures.group, pipeline, encoder, input);
        }
    }
}

impl Recorder for MapNode {
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError> {
        self.prepare_maps(world, input, |request| !request.apart)
    }

    fn draw_pictures(&self, encoder: &mut wgpu::CommandEncoder, input: &PictureInput) {
        let mut recorded = Recorded::default();
        for (slot, plan) in self.keepers() {
            self.draw_faces(slot, plan, encoder, input, &mut recorded);
        }
        recorded.confirm_on_submission(encoder);
    }

    fn light(&self, light: usize) -> Option<Leaves<'_>> {
        self.plan_of(light).map(|_| Leaves::Mask(self))
    }

    /// Draws the edges of the volumes that the faces show.
    fn debug(&self, light: usize, pass: &mut wgpu::RenderPass, _input: &RecordInput) {
        let pipeline = self.pipelines.get(Key::Frustum);
        if let (Some((_, plan)), Some(pipeline)) = (self.plan_of(light), pipeline) {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &self.caster_group, &[]);
            pass.draw(0..24, plan.frusta.clone());
        }
    }

    /// Returns the number of draws of casters. It leaves out the lookup, which is one draw of one triangle.
    fn batch_count(&self, light: usize) -> usize {
        self.plan_of(light).map_or(0, |(_, plan)| plan.draw_count)
    }
}
