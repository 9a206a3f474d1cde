//! What lives long on the GPU.

use bevy_ecs::prelude::*;
use glam::{DMat4, UVec2};

use super::frame::draw_list::DrawListBuilder;
use super::frame::frame_data::{ActiveLight, FrameData};
use super::frame::hosted::HostView;
use super::frame::targets::{MaskTargets, RadianceTarget};
use super::gpu::bind_groups::{BindGroupLayouts, LIGHT_STRIDE, bind_in_order};
use super::gpu::buffers::GrowingBuffer;
use super::gpu::timings::Timings;
use super::nodes::depth_copy::DepthCopy;
use super::nodes::host_depth::HostDepth;
use super::nodes::host_select::HostSelect;
use super::nodes::light_begin::LightBegin;
use super::nodes::pipelines::SurfacePipelines;
use super::nodes::surfaces::SurfaceResources;
use super::nodes::tonemap::Tonemap;
use super::pools::gpu_types;
use super::pools::materials::MaterialPool;
use super::pools::meshes::{MeshPool, OversizedMesh};
use super::pools::objects::ObjectTable;
use super::recorder::{RecordInput, Recorder};
use super::settings::RenderSettings;
use super::{FrameTargets, RenderContext, RenderError, Shaders};

/// Draws frames. A resource; systems of [`systems`](super::frame::prepare) prepare it, [`Renderer::record`] draws.
#[derive(Resource)]
pub struct Renderer {
    /// How the frame is drawn.
    pub settings: RenderSettings,
    pub(super) context: RenderContext,
    pub(super) shaders: Shaders,
    pub(super) layouts: BindGroupLayouts,
    pub(super) pipelines: SurfacePipelines,
    pub(super) light_begin: LightBegin,
    pub(super) tonemap: Tonemap,
    pub(super) meshes: MeshPool,
    pub(super) materials: MaterialPool,
    pub(super) table: ObjectTable,
    pub(super) table_generation: Option<u64>,
    pub(super) last_clip_from_world: Option<DMat4>,
    pub(super) view_buffer: wgpu::Buffer,
    pub(super) objects: GrowingBuffer,
    pub(super) light_buffer: GrowingBuffer,
    pub(super) instances: GrowingBuffer,
    pub(super) view_group: wgpu::BindGroup,
    pub(super) light_group: wgpu::BindGroup,
    pub(super) draw_lists: DrawListBuilder,
    pub(super) techniques: Vec<Box<dyn Recorder>>,
    pub(super) targets: Option<FrameTargets>,
    pub(super) radiance: Option<(RadianceTarget, wgpu::BindGroup)>,
    pub(super) host: Option<HostView>,
    pub(super) host_depth: Option<HostDepth>,
    pub(super) host_select: Option<HostSelect>,
    pub(super) front: Option<FrameTargets>,
    pub(super) masks: Option<MaskTargets>,
    pub(super) depth_copy: DepthCopy,
    pub(super) labels: Vec<String>,
    pub(super) frame: FrameData,
    pub(super) timings: Timings,
    pub(super) failure: Option<RenderError>,
}

impl std::fmt::Debug for Renderer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Renderer")
            .field("settings", &self.settings)
            .field("context", &self.context)
            .field("frame", &self.frame)
            .finish_non_exhaustive()
    }
}

impl Renderer {
    /// A renderer. The schedule gives it the crate's own techniques in its first frame
    /// ([`add_builtin_techniques`](crate::techniques::add_builtin_techniques)).
    ///
    /// # Errors
    /// [`RenderError::Shader`] if a shader does not compose.
    pub fn new(context: RenderContext) -> Result<Self, RenderError> {
        let shaders = Shaders::new()?;
        let layouts = BindGroupLayouts::new(&context.device);
        let pipelines = SurfacePipelines::new(&context, &shaders, &layouts)?;
        let storage = wgpu::BufferUsages::STORAGE;
        let objects = GrowingBuffer::new(&context, "objects", storage);
        let light_buffer = GrowingBuffer::new(&context, "lights", wgpu::BufferUsages::UNIFORM);
        let view_buffer = context.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("view"),
            size: size_of::<gpu_types::View>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Ok(Self {
            settings: RenderSettings::default(),
            light_begin: LightBegin::new(&context, &shaders)?,
            tonemap: Tonemap::new(&context, &shaders, &layouts)?,
            meshes: MeshPool::default(),
            materials: MaterialPool::new(&context),
            table: ObjectTable::default(),
            table_generation: None,
            last_clip_from_world: None,
            view_group: bind_view(&context, &layouts, &view_buffer, &objects.buffer),
            light_group: bind_lights(&context, &layouts, &light_buffer.buffer),
            instances: GrowingBuffer::new(&context, "instances", wgpu::BufferUsages::VERTEX),
            draw_lists: DrawListBuilder::default(),
            techniques: Vec::new(),
            targets: None,
            radiance: None,
            host: None,
            host_depth: None,
            host_select: None,
            front: None,
            masks: None,
            depth_copy: DepthCopy::new(&context, &shaders, &layouts)?,
            labels: Vec::new(),
            frame: FrameData::default(),
            timings: Timings::new(&context),
            failure: None,
            context,
            shaders,
            layouts,
            pipelines,
            view_buffer,
            objects,
            light_buffer,
        })
    }

    /// Adds a technique; lights that it claims are shadowed by it. Earlier ones are asked first.
    pub fn add_technique(&mut self, technique: Box<dyn Recorder>) {
        self.techniques.push(technique);
    }

    /// Whether a technique of this name was added.
    pub fn has_technique(&self, name: &str) -> bool {
        self.techniques.iter().any(|technique| technique.name() == name)
    }

    /// The device.
    pub fn context(&self) -> &RenderContext {
        &self.context
    }

    /// Shader composition, for techniques of third parties.
    pub fn shaders(&self) -> &Shaders {
        &self.shaders
    }

    /// The layouts that passes share.
    pub fn layouts(&self) -> &BindGroupLayouts {
        &self.layouts
    }

    /// Depth and stencil of the last frame; `None` before the first, or for a frame without pixels.
    pub fn targets(&self) -> Option<&FrameTargets> {
        self.targets.as_ref()
    }

    /// Radiance of the last frame; `None` before the first, for a frame without pixels, or with a host.
    pub fn radiance(&self) -> Option<&RadianceTarget> {
        self.radiance.as_ref().map(|(radiance, _)| radiance)
    }

    /// The mask and the depth that techniques read; `None` before the first frame with a mask of this size.
    pub fn mask_targets(&self) -> Option<&MaskTargets> {
        self.masks.as_ref()
    }

    /// What the last prepared frame draws.
    pub fn frame(&self) -> &FrameData {
        &self.frame
    }

    /// GPU times of the last recorded frame.
    pub fn timings(&self) -> &Timings {
        &self.timings
    }

    /// Pipelines made so far; does not grow in a steady frame.
    pub fn pipelines_created(&self) -> usize {
        self.pipelines.created
    }

    /// Objects that are not drawn because the device allows no buffer of their mesh's size.
    pub fn oversized_meshes(&self) -> &[OversizedMesh] {
        &self.meshes.oversized
    }

    /// Name of the technique of one light of the frame, `none` without.
    pub fn technique_name(&self, light: &ActiveLight) -> &'static str {
        light
            .shadow
            .map_or("none", |(technique, _)| self.techniques[technique].name())
    }

    /// Draw calls of the technique of one light of the frame.
    pub fn shadow_batch_count(&self, light: &ActiveLight) -> usize {
        light.shadow.map_or(0, |(technique, _)| {
            self.techniques[technique].batch_count(light.light)
        })
    }

    /// What went wrong while the frame was prepared, if anything and if nobody took it.
    pub fn failure(&self) -> Option<&RenderError> {
        self.failure.as_ref()
    }

    /// What went wrong while the frame was prepared, if anything; such a frame draws nothing.
    pub fn take_failure(&mut self) -> Option<RenderError> {
        self.failure.take()
    }

    /// Makes this frame draw nothing, for what a system between `prepare_objects` and `prepare_draws` could not do.
    pub fn fail(&mut self, failure: RenderError) {
        self.failure.get_or_insert(failure);
    }

    pub(super) fn resize(&mut self, size: UVec2) -> Result<(), RenderError> {
        let is_there = self.targets.as_ref().is_some_and(|targets| targets.size == size);
        if is_there && self.radiance.is_none() == self.host.is_some() {
            return Ok(());
        }
        self.targets = None;
        self.radiance = None;
        self.front = None;
        self.masks = None;
        if size.min_element() == 0 {
            return Ok(()); // there is nothing to draw
        }
        let targets = FrameTargets::new(&self.context, &self.layouts, "depth and stencil", size)?;
        if self.host.is_none() {
            let radiance = RadianceTarget::new(&self.context, size)?;
            let tonemap_group = self.tonemap.bind(&self.context, &radiance.view);
            self.radiance = Some((radiance, tonemap_group));
        }
        self.targets = Some(targets);
        Ok(())
    }

    /// Makes the targets of masks and of the front layer if a light of the frame needs them.
    pub(super) fn require_targets(&mut self) -> Result<(), RenderError> {
        let Some(targets) = &self.targets else {
            return Ok(());
        };
        if self.masks.is_none() && self.frame.lights.iter().any(ActiveLight::has_mask) {
            self.masks = Some(MaskTargets::new(&self.context, &self.layouts, targets)?);
        }
        if self.front.is_none() && self.frame.has_front_layer() {
            let label = "front depth and stencil";
            self.front = Some(FrameTargets::new(
                &self.context,
                &self.layouts,
                label,
                targets.size,
            )?);
        }
        Ok(())
    }

    pub(super) fn write_objects(&mut self) {
        let bytes = bytemuck::cast_slice(self.table.constants());
        if self.objects.write(&self.context, bytes) {
            self.view_group = bind_view(
                &self.context,
                &self.layouts,
                &self.view_buffer,
                &self.objects.buffer,
            );
        }
    }

    pub(super) fn write_lights(&mut self) {
        if self
            .light_buffer
            .write(&self.context, &self.frame.light_constants)
        {
            self.light_group = bind_lights(&self.context, &self.layouts, &self.light_buffer.buffer);
        }
    }

    pub(super) fn surface_resources(&self) -> SurfaceResources<'_> {
        SurfaceResources {
            pipelines: &self.pipelines,
            meshes: &self.meshes,
            materials: &self.materials,
            instances: &self.instances.buffer,
        }
    }

    pub(super) fn record_input(&self) -> RecordInput<'_> {
        RecordInput {
            view: &self.view_group,
            meshes: &self.meshes,
            materials: &self.materials,
            table: &self.table,
            viewport: self.frame.viewport,
            casters: None,
        }
    }
}

fn bind_view(
    context: &RenderContext,
    layouts: &BindGroupLayouts,
    view: &wgpu::Buffer,
    objects: &wgpu::Buffer,
) -> wgpu::BindGroup {
    bind_in_order(
        &context.device,
        "view",
        &layouts.view,
        [view.as_entire_binding(), objects.as_entire_binding()],
    )
}

fn bind_lights(
    context: &RenderContext,
    layouts: &BindGroupLayouts,
    lights: &wgpu::Buffer,
) -> wgpu::BindGroup {
    bind_in_order(
        &context.device,
        "lights",
        &layouts.light,
        [wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: lights,
            offset: 0,
            size: std::num::NonZeroU64::new(LIGHT_STRIDE.min(size_of::<gpu_types::Light>() as u64)),
        })],
    )
}
