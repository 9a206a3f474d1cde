//! The GPU resources of one view, and the recorders of its techniques.

use std::any::TypeId;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use bevy_ecs::prelude::*;
use bevy_ecs::world::WorldId;

use super::frame::draw_list::DrawListBuilder;
use super::frame::frame_data::{ActiveLight, FrameData};
use super::frame::hosted::HostView;
use super::frame::labels::LightLabels;
use super::frame::targets::{MaskTargets, RadianceTarget};
use super::gpu::bind_groups::bind_in_order;
use super::gpu::buffers::GrowingBuffer;
use super::gpu::strided::StridedUniforms;
use super::gpu::timings::Timings;
use super::light_function::LightFunction;
use super::light_model::barn_maps::BarnMapParts;
use super::light_model::function::{LightModelFunction, is_scaled};
use super::light_model::textures::function::LightTextureFunction;
use super::nodes::darker_mask::DarkerMask;
use super::nodes::depth_copy::DepthCopy;
use super::nodes::host_depth::HostDepth;
use super::nodes::host_select::HostSelect;
use super::nodes::host_weights::HostWeights;
use super::nodes::keep_visibility::KeepVisibility;
use super::nodes::light_begin::LightBegin;
use super::nodes::light_function::StencilToMask;
use super::nodes::pipelines::SurfacePipelines;
use super::nodes::surfaces::SurfaceResources;
use super::nodes::tonemap::Tonemap;
use super::pools::gpu_types;
use super::pools::materials::MaterialPool;
use super::pools::meshes::{MeshPool, OversizedMesh};
use super::pools::object_rows::ObjectView;
use super::pools::objects::ObjectTable;
use super::recorder::{Leaves, Recorder};
use super::recorders::Recorders;
use super::settings::RenderSettings;
use super::{FrameTargets, Gpu, RenderContext, RenderError};
use crate::sets::FrameLights;

/// Draws the frames of one view. It is a resource: the systems of the set `PrepareGpu` prepare a frame, and
/// [`Renderer::record`] records it. The commands of a frame must be submitted before the schedule runs for the next one: what the
/// schedule writes to the device's queue would come before them.
///
/// A renderer may go from one world to another. It then keeps its settings, targets and light functions, and makes everything else
/// again in its first frame there, so that a renderer for each world is faster for worlds that take turns.
#[derive(Resource)]
pub struct Renderer {
    /// The settings by which the frame is drawn.
    pub settings: RenderSettings,
    pub(super) gpu: Arc<Gpu>,
    pub(super) pipelines: SurfacePipelines,
    pub(super) light_begin: LightBegin,
    pub(super) tonemap: Tonemap,
    pub(super) meshes: MeshPool,
    pub(super) materials: MaterialPool,
    pub(super) table: ObjectTable,
    pub(super) table_generation: Option<u64>,
    /// The layout of the objects, and the view, of the matrices on the device.
    pub(super) matrices_of: Option<(u64, ObjectView)>,
    /// The last [`Objects::frame`](crate::sets::Objects::frame) for which the renderer was prepared.
    pub(super) last_frame: u64,
    /// The world of that frame.
    world: Option<WorldId>,
    /// True after a frame that failed: what changed in it has not reached the GPU.
    pub(super) has_missed_changes: bool,
    pub(super) view_buffer: wgpu::Buffer,
    pub(super) objects: GrowingBuffer,
    pub(super) lights: StridedUniforms<gpu_types::Light>,
    pub(super) instances: GrowingBuffer,
    pub(super) view_group: wgpu::BindGroup,
    pub(super) light_group: wgpu::BindGroup,
    pub(super) draw_lists: DrawListBuilder,
    pub(super) techniques: Recorders,
    pub(super) functions: Vec<Box<dyn LightFunction>>,
    has_light_model: bool,
    has_light_textures: bool,
    pub(super) stencil_to_mask: Option<StencilToMask>,
    pub(super) darker_mask: Option<DarkerMask>,
    pub(super) targets: Option<FrameTargets>,
    pub(super) radiance: Option<(RadianceTarget, wgpu::BindGroup)>,
    pub(super) host: Option<HostView>,
    pub(super) host_terms: bool,
    pub(super) host_depth: Option<HostDepth>,
    pub(super) host_select: Option<HostSelect>,
    pub(super) host_weights: Option<HostWeights>,
    pub(super) keep_visibility: Option<KeepVisibility>,
    pub(super) front: Option<FrameTargets>,
    pub(super) masks: Option<MaskTargets>,
    pub(super) depth_copy: DepthCopy,
    pub(super) labels: LightLabels,
    pub(super) frame: FrameData,
    pub(super) timings: Timings,
    pub(super) failure: Option<RenderError>,
    /// The first error since the last frame was prepared. It becomes the failure of the next one.
    pub(super) late_failure: Option<RenderError>,
    /// True while the systems prepare a frame.
    pub(super) is_preparing: bool,
}

impl std::fmt::Debug for Renderer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Renderer")
            .field("settings", &self.settings)
            .field("gpu", &self.gpu)
            .field("frame", &self.frame)
            .finish_non_exhaustive()
    }
}

impl Renderer {
    /// Makes the renderer of one view, with a device that no other view shares.
    ///
    /// # Errors
    /// [`RenderError::Shader`] if a shader does not compose.
    pub fn new(context: RenderContext) -> Result<Self, RenderError> {
        Self::on(Arc::new(Gpu::new(context)?))
    }

    /// Makes the renderer of one view. It shares pipelines, meshes and materials with all views that draw on
    /// `gpu`. The schedule gives it the crate's own techniques in its first frame.
    ///
    /// # Errors
    /// [`RenderError::Shader`] if a shader does not compose.
    pub fn on(gpu: Arc<Gpu>) -> Result<Self, RenderError> {
        let context = &gpu.context;
        let objects = GrowingBuffer::new(context, "objects", wgpu::BufferUsages::STORAGE);
        let lights = StridedUniforms::new(context, "lights");
        let view_buffer = context.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("view"),
            size: size_of::<gpu_types::View>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Ok(Self {
            settings: RenderSettings::default(),
            pipelines: SurfacePipelines::new(&gpu)?,
            light_begin: LightBegin::new(&gpu)?,
            tonemap: Tonemap::new(&gpu)?,
            meshes: MeshPool::default(),
            materials: MaterialPool::default(),
            table: ObjectTable::default(),
            table_generation: None,
            matrices_of: None,
            last_frame: 0,
            world: None,
            has_missed_changes: false,
            view_group: bind_view(&gpu, &view_buffer, &objects.buffer),
            light_group: bind_lights(&gpu, &lights),
            instances: GrowingBuffer::new(context, "instances", wgpu::BufferUsages::VERTEX),
            draw_lists: DrawListBuilder::default(),
            techniques: Recorders::default(),
            functions: Vec::new(),
            has_light_model: false,
            has_light_textures: false,
            stencil_to_mask: None,
            darker_mask: None,
            targets: None,
            radiance: None,
            host: None,
            host_terms: false,
            host_depth: None,
            host_select: None,
            host_weights: None,
            keep_visibility: None,
            front: None,
            masks: None,
            depth_copy: DepthCopy::new(&gpu)?,
            labels: LightLabels::default(),
            frame: FrameData::default(),
            timings: Timings::new(context),
            failure: None,
            late_failure: None,
            is_preparing: false,
            view_buffer,
            objects,
            lights,
            gpu,
        })
    }

    /// Forgets what was made for another world. Worlds count frames and revisions by themselves, so that equal numbers of two
    /// worlds say nothing.
    pub(super) fn enter(&mut self, world: WorldId) {
        if self.world.replace(world).is_some_and(|last| last != world) {
            self.techniques = Recorders::default();
            self.table_generation = None;
            self.matrices_of = None;
            self.has_missed_changes = true;
        }
    }

    /// The recorders of the world's techniques.
    pub fn recorders(&self) -> &Recorders {
        &self.techniques
    }

    /// Adds the recorder of the next technique of the world's list ([`Recorders`]).
    ///
    /// # Errors
    /// Returns the error of `make`.
    pub(crate) fn add_recorder(
        &mut self,
        kind: TypeId,
        make: impl FnOnce(&Gpu) -> Result<Box<dyn Recorder>, RenderError>,
    ) -> Result<(), RenderError> {
        if !self.techniques.knows(kind) {
            let recorder = make(&self.gpu)?;
            self.techniques.push(kind, recorder);
        }
        self.techniques.add_row(kind);
        Ok(())
    }

    /// Adds a function that scales the radiance that lights give at each surface. If several functions scale
    /// the same light, their factors are multiplied.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn add_light_function(&mut self, function: Box<dyn LightFunction>) -> Result<(), RenderError> {
        if self.stencil_to_mask.is_none() {
            self.stencil_to_mask = Some(StencilToMask::new(&self.gpu)?);
        }
        self.functions.push(function);
        Ok(())
    }

    /// Returns whether any function was added that can scale lights.
    pub fn has_light_functions(&self) -> bool {
        !self.functions.is_empty()
    }

    /// Adds the functions of the light model, each with the first light that needs it. A renderer whose lights have no
    /// model makes nothing of it.
    pub(super) fn require_light_model(&mut self, lights: &FrameLights) -> Result<(), RenderError> {
        if !self.has_light_model && lights.lights.iter().any(is_scaled) {
            let function = LightModelFunction::new(&self.gpu)?;
            self.add_light_function(Box::new(function))?;
            self.has_light_model = true;
        }
        if !self.has_light_textures && lights.lights.iter().any(|light| !light.textures.is_empty()) {
            let function = LightTextureFunction::new(&self.gpu);
            self.add_light_function(Box::new(function))?;
            self.has_light_textures = true;
        }
        Ok(())
    }

    /// The long-lived part that this view shares with others: device, shaders, layouts, pipelines, meshes,
    /// materials.
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// The device and its queue.
    pub fn context(&self) -> &RenderContext {
        &self.gpu.context
    }

    /// Depth and stencil of the last frame. It is `None` before the first frame, and for a frame without
    /// pixels.
    pub fn targets(&self) -> Option<&FrameTargets> {
        self.targets.as_ref()
    }

    /// Radiance of the last frame. It is `None` before the first frame, for a frame without pixels, and with
    /// a host.
    pub fn radiance(&self) -> Option<&RadianceTarget> {
        self.radiance.as_ref().map(|(radiance, _)| radiance)
    }

    /// The mask and the depth that techniques read. It is `None` before the first frame of this size that has
    /// a light with a mask.
    pub fn mask_targets(&self) -> Option<&MaskTargets> {
        self.masks.as_ref()
    }

    /// The draws and lights of the last prepared frame.
    pub fn frame(&self) -> &FrameData {
        &self.frame
    }

    /// GPU times of the last recorded frame.
    pub fn timings(&self) -> &Timings {
        &self.timings
    }

    /// The number of pipelines made so far for all views of the device. It does not grow in a steady frame.
    pub fn pipelines_created(&self) -> usize {
        self.gpu.pipeline_count()
    }

    /// The number of barn maps ([`BarnMap`](crate::scene::BarnMap)) drawn so far for all views of the device. It does
    /// not grow in a steady frame.
    pub fn barn_maps_made(&self) -> usize {
        self.gpu.part(BarnMapParts::new).made.load(Ordering::Relaxed)
    }

    /// The objects that are not drawn because the device allows no buffer of their mesh's size.
    pub fn oversized_meshes(&self) -> &[OversizedMesh] {
        &self.meshes.oversized
    }

    /// The name of the technique that shadows one light of the frame, or `none` if nothing shadows it.
    pub fn technique_name(&self, light: &ActiveLight) -> &'static str {
        light.technique.map_or("none", |technique| technique.name)
    }

    /// The number of draw calls that the shadows of one light of the frame take, with those of its companions.
    pub fn shadow_batch_count(&self, light: &ActiveLight) -> usize {
        let own = light.shadow.map_or(0, |shadow| {
            self.techniques[shadow.technique.0].batch_count(light.light)
        });
        let companions = self.frame.companions_of(light);
        own + companions
            .map(|companion| self.shadow_batch_count(companion))
            .sum::<usize>()
    }

    /// The error of the last prepared frame, or else of what was done since, unless [`Renderer::take_failure`] has taken it.
    pub fn failure(&self) -> Option<&RenderError> {
        self.failure.as_ref().or(self.late_failure.as_ref())
    }

    /// Takes the error of the last prepared frame, or else of what was done since. A frame with an error draws nothing.
    pub fn take_failure(&mut self) -> Option<RenderError> {
        self.failure.take().or_else(|| self.late_failure.take())
    }

    /// Makes the frame that is prepared next draw nothing, because of an error. A system that runs before the set
    /// [`PrepareGpu`](crate::schedule::AntumbraSystems::PrepareGpu) does this to the frame of its own run of the schedule. The
    /// frame has the error, unless [`Renderer::take_failure`] takes it first. The first error of a frame is kept.
    pub fn fail(&mut self, failure: RenderError) {
        let of_frame = if self.is_preparing {
            &mut self.failure
        } else {
            &mut self.late_failure
        };
        of_frame.get_or_insert(failure);
    }

    pub(super) fn surface_resources(&self) -> SurfaceResources<'_> {
        SurfaceResources {
            pipelines: &self.pipelines,
            meshes: &self.meshes,
            materials: &self.materials,
            instances: &self.instances.buffer,
        }
    }

    /// The result that the technique of a light leaves of it.
    pub(super) fn leaves(&self, light: &ActiveLight) -> Option<Leaves<'_>> {
        self.techniques[light.shadow?.technique.0].light(light.light)
    }
}

pub(super) fn bind_view(gpu: &Gpu, view: &wgpu::Buffer, objects: &wgpu::Buffer) -> wgpu::BindGroup {
    bind_in_order(
        &gpu.context.device,
        "view",
        &gpu.layouts.view,
        [view.as_entire_binding(), objects.as_entire_binding()],
    )
}

pub(super) fn bind_lights(gpu: &Gpu, lights: &StridedUniforms<gpu_types::Light>) -> wgpu::BindGroup {
    let layout = &gpu.layouts.light;
    bind_in_order(&gpu.context.device, "lights", layout, [lights.binding()])
}
