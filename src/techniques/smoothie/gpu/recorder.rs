//! Draws smoothies beside the maps that changed, and looks both up into the mask.
//!
//! Shaders `shaders/techniques/smoothie/{edge,resolve}.wgsl`
//! Groups  edges: 0 edges, 1 face, 2 depths; lookup: 0 view, 1 receiver, 2 map, 3 depths and smoothies
//! Reads   receiver depth and plane.  Writes  the mask, inside the light's scissor
//! Order   after `depth copy` and `receiver plane`, before `light_accumulate` of the same light
//!
//! The recorder of maps draws the casters' depth, for these lights too, and chooses which faces are drawn again. The
//! smoothies of still casters are drawn once, beside the still layer, and copied under those of moving casters.

use std::ops::Range;
use std::sync::Arc;

use bevy_ecs::prelude::*;

use super::pipelines::{FILES, Key, SmoothieLayouts, describe};
use super::plans::{PlannedLight, Smoothies};
use crate::render::gpu::bind_groups::bind_in_order;
use crate::render::gpu::buffers::GrowingBuffer;
use crate::render::gpu::pipeline_cache::Variants;
use crate::render::gpu::strided::StridedUniforms;
use crate::render::recorder::{
    Leaves, PictureInput, PrepareInput, RecordInput, Recorder, Resolve, ResolveInput,
};
use crate::render::{Gpu, RenderContext, RenderError};
use crate::techniques::maps::Maps;
use crate::techniques::maps::gpu::plans::LightPlan;
use crate::techniques::maps::gpu::recorded::Recorded;
use crate::techniques::maps::gpu::recorder::MapNode;
use crate::techniques::maps::request::MapShape;
use crate::techniques::smoothie::records::SmoothieFace;

/// The smoothies that one face needs, in the order of the recorder of maps.
#[derive(Debug)]
pub struct SmoothiePlan {
    /// Ranges of draws of still casters, or of all casters if the map is not kept.
    pub still: Range<usize>,
    /// Ranges of draws of moving casters.
    pub moving: Range<usize>,
}

/// The recorder of smoothies.
#[derive(Debug)]
pub struct SmoothieNode {
    pub(super) maps: MapNode,
    layouts: Arc<SmoothieLayouts>,
    pub(super) pipelines: Variants<Key>,
    pub(super) smoothies: Smoothies,
    edges: GrowingBuffer,
    pub(super) edge_group: wgpu::BindGroup,
    faces: StridedUniforms<SmoothieFace>,
    pub(super) face_group: wgpu::BindGroup,
    pub(super) plans: Vec<SmoothiePlan>,
}

impl SmoothieNode {
    /// Compiles the shaders. Pipelines and textures are made when a frame needs them.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        gpu.compile(&FILES)?;
        let context = &gpu.context;
        let layouts = gpu.part(|gpu| SmoothieLayouts::new(&gpu.context.device));
        let edges = GrowingBuffer::new(context, "smoothie edges", wgpu::BufferUsages::STORAGE);
        let faces = StridedUniforms::new(context, "smoothie faces");
        Ok(Self {
            maps: MapNode::new(gpu)?,
            pipelines: Variants::default(),
            smoothies: Smoothies::default(),
            edge_group: bind_edges(context, &layouts, &edges),
            face_group: bind_faces(context, &layouts, &faces),
            plans: Vec::new(),
            layouts,
            edges,
            faces,
        })
    }

    fn require(&mut self, gpu: &Gpu, key: Key) -> Result<(), RenderError> {
        let (layouts, maps) = (&self.layouts, &self.maps.long_lived.layouts);
        gpu.require(&mut self.pipelines, key, |gpu| describe(gpu, layouts, maps, key))
    }

    /// The key of a light's lookup.
    pub(super) fn lookup(plan: &LightPlan) -> Key {
        let shape = plan.request.shape;
        let cascade_count = match shape {
            MapShape::Cascades => plan.request.face_count(),
            _ => 1,
        };
        Key::Resolve { shape, cascade_count }
    }

    /// Plans the smoothies of the faces that the recorder of maps draws for one light.
    fn plan_light(&mut self, world: &World, index: usize) {
        let plan = &self.maps.lights[index];
        let Some(map) = world.resource::<Maps>().of_light(plan.light) else {
            return;
        };
        let Some(beside) = map.request.beside else {
            return;
        };
        self.smoothies.begin_light();
        for face_plan in &self.maps.faces[plan.faces.clone()] {
            let state = &map.faces[face_plan.face];
            let light = PlannedLight {
                map,
                anchor: map.faces[0].face.origin,
                is_parallel: map.request.shape == MapShape::Cascades,
            };
            let darkens = beside.metres > 0.0 || beside.share > 0.0;
            let mut push = |set, wanted: bool| {
                if wanted && darkens {
                    self.smoothies.push(world, &light, set)
                } else {
                    0..0
                }
            };
            let own = if map.cached { &state.still } else { &state.moving };
            let plan = SmoothiePlan {
                still: push(own, face_plan.still.is_some()),
                moving: push(&state.moving, face_plan.moving.is_some()),
            };
            self.plans.push(plan);
            let face = SmoothieFace::new(&state.face, light.anchor, map.resolution, &beside);
            self.faces.constants.push(&face);
        }
    }
}

fn bind_edges(context: &RenderContext, layouts: &SmoothieLayouts, edges: &GrowingBuffer) -> wgpu::BindGroup {
    let buffer = edges.buffer.as_entire_binding();
    bind_in_order(&context.device, "smoothie edges", &layouts.edges, [buffer])
}

fn bind_faces(
    context: &RenderContext,
    layouts: &SmoothieLayouts,
    faces: &StridedUniforms<SmoothieFace>,
) -> wgpu::BindGroup {
    bind_in_order(&context.device, "smoothie face", &layouts.face, [faces.binding()])
}

impl Recorder for SmoothieNode {
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError> {
        self.maps
            .prepare_maps(world, input, |request| request.apart && request.beside.is_some())?;
        self.smoothies.clear();
        self.plans.clear();
        self.faces.constants.clear();
        for index in 0..self.maps.lights.len() {
            self.require(input.gpu, Self::lookup(&self.maps.lights[index]))?;
            self.plan_light(world, index);
        }
        if !self.smoothies.draws.is_empty() {
            self.require(input.gpu, Key::Edges)?;
        }
        let context = input.context;
        let edges: &[u8] = bytemuck::cast_slice(&self.smoothies.edges);
        let limits = context.device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        if edges.len() as u64 > limit {
            return Err(RenderError::Limit {
                what: "smoothie edges of all lights",
                needed: edges.len() as u64,
                limit,
            });
        }
        if self.edges.write(context, edges) {
            self.edge_group = bind_edges(context, &self.layouts, &self.edges);
        }
        if self.faces.write(context) {
            self.face_group = bind_faces(context, &self.layouts, &self.faces);
        }
        Ok(())
    }

    fn draw_pictures(&self, encoder: &mut wgpu::CommandEncoder, input: &PictureInput) {
        let mut recorded = Recorded::default();
        for (slot, plan) in self.maps.keepers() {
            self.draw_light(slot, plan, encoder, input, &mut recorded);
        }
        recorded.confirm_on_submission(encoder);
    }

    fn light(&self, light: usize) -> Option<Leaves<'_>> {
        self.maps.plan_of(light).map(|_| Leaves::Mask(self))
    }

    /// Draws the edges of the volumes that the faces show.
    fn debug(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput) {
        self.maps.debug(light, pass, input);
    }

    /// Returns the number of draws of casters and smoothies. It leaves out the lookup, which is one draw of one
    /// triangle.
    fn batch_count(&self, light: usize) -> usize {
        let plan = self.maps.plan_of(light);
        let plans = plan.map_or(&[][..], |(_, plan)| &self.plans[plan.faces.clone()]);
        let smoothies: usize = plans
            .iter()
            .map(|plan| plan.still.len() + plan.moving.len())
            .sum();
        self.maps.batch_count(light) + smoothies
    }
}

impl Resolve for SmoothieNode {
    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        let Some((slot, plan)) = self.maps.plan_of(light) else {
            return;
        };
        if plan.takes_turns {
            // Another light may have used the textures since, so they are drawn before each lookup.
            self.draw_light(slot, plan, encoder, &input.pictures(), &mut Recorded::default());
        }
        let textures = self
            .maps
            .pool
            .get(&plan.key)
            .and_then(|textures| textures.beside.as_ref());
        if let (Some(textures), Some(pipeline)) = (textures, self.pipelines.get(Self::lookup(plan))) {
            self.maps.look_up(slot, &textures.group, pipeline, encoder, input);
        }
    }
}
