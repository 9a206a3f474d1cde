//! What lives long on the GPU, and what a frame puts into it.

use std::ops::Range;

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;
use glam::{DMat4, UVec2, Vec3};

use super::bind_groups::{BindGroupLayouts, LIGHT_STRIDE};
use super::buffers::GrowingBuffer;
use super::draw_list::{Batch, DrawListBuilder};
use super::materials::MaterialPool;
use super::meshes::MeshPool;
use super::nodes::blended::{BlendedDraw, BlendedLight};
use super::nodes::depth_copy::DepthCopy;
use super::nodes::light_begin::LightBegin;
use super::nodes::surfaces::SurfaceResources;
use super::nodes::tonemap::Tonemap;
use super::objects::ObjectTable;
use super::pipelines::SurfacePipelines;
use super::targets::MaskTargets;
use super::technique::{RecordInput, ShadowTechnique, Visibility};
use super::timings::Timings;
use super::{FrameTargets, RenderContext, RenderError, Shaders, gpu_types};

/// How the frame is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// Linear RGB radiance that reaches every surface from everywhere.
    pub ambient: Vec3,
    /// Linear RGB where nothing is.
    pub background: Vec3,
    /// Factor on radiance before the tonemap.
    pub exposure: f32,
    /// Restricts each light to its depth bounds on the GPU.
    pub depth_bounds: bool,
    /// Restricts each light to its scissor.
    pub scissor: bool,
    /// Draws the shadow geometry of every light over the picture.
    pub debug_volumes: bool,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            ambient: Vec3::splat(0.02),
            background: Vec3::ZERO,
            exposure: 1.0,
            depth_bounds: true,
            scissor: true,
            debug_volumes: false,
        }
    }
}

impl RenderSettings {
    /// The settings with numbers that can be drawn with: radiance that is not finite or negative counts as 0, such an
    /// exposure as 1.
    pub fn sanitized(&self) -> Self {
        let usable = |x: f32| x.is_finite() && x >= 0.0;
        let radiance = |v: Vec3| Vec3::from_array(v.to_array().map(|x| if usable(x) { x } else { 0.0 }));
        Self {
            ambient: radiance(self.ambient),
            background: radiance(self.background),
            exposure: if usable(self.exposure) { self.exposure } else { 1.0 },
            ..*self
        }
    }
}

/// One light of the frame, ready to record.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveLight {
    /// Index into [`FrameLights`](crate::sets::FrameLights).
    pub light: usize,
    /// Slot of the light's constants.
    pub slot: usize,
    /// Index of its technique and what that leaves; `None`: unshadowed.
    pub shadow: Option<(usize, Visibility)>,
    /// x, y, width, height; pixels.
    pub scissor: [u32; 4],
    /// Nearest and farthest depth that it reaches, 1 ≥ near ≥ far ≥ 0.
    pub depth_range: (f32, f32),
    /// Range of [`FrameData::batches`].
    pub batches: Range<usize>,
    /// Range of [`FrameData::batches`]: blended surfaces, whose front layer it lights with its shadows. Empty without a
    /// technique.
    pub front: Range<usize>,
    /// The part of the scissor that shows them.
    pub front_scissor: [u32; 4],
}

impl ActiveLight {
    /// Whether its technique leaves a mask.
    pub fn has_mask(&self) -> bool {
        matches!(self.shadow, Some((_, Visibility::Mask)))
    }
}

/// What changes every frame; its memory is kept.
#[derive(Debug, Default)]
pub struct FrameData {
    /// All draws of surfaces.
    pub batches: Vec<Batch>,
    /// Objects by instance.
    pub instances: Vec<u32>,
    /// Range of `batches`: the visible set V.
    pub ambient: Range<usize>,
    /// Lights with something to light.
    pub lights: Vec<ActiveLight>,
    /// By index into [`FrameLights`](crate::sets::FrameLights), ranges of `batches`: surfaces that the light does not see.
    /// Drawn into pictures of its visibility alone.
    pub dark: Vec<(usize, Range<usize>)>,
    /// Blended surfaces, farthest first.
    pub blended: Vec<BlendedDraw>,
    /// The lights of blended surfaces.
    pub blended_lights: Vec<BlendedLight>,
    /// Range of `batches`: all blended surfaces.
    pub blended_batches: Range<usize>,
    /// Bytes of the light constants.
    pub light_constants: Vec<u8>,
    /// For each of `lights` the casters whose shadows can reach its front layer, by dense object index.
    pub front_casters: Vec<FixedBitSet>,
    /// Whether there is a view to draw.
    pub has_view: bool,
    /// For sorting blended surfaces: distance, object, item.
    pub blended_order: Vec<(u32, u32, u32)>,
}

impl FrameData {
    /// Whether a shadowed light reaches a blended surface.
    pub fn has_front_layer(&self) -> bool {
        self.lights.iter().any(|light| !light.front.is_empty())
    }
}

/// Draws frames. A resource; systems of [`systems`](super::systems) prepare it, [`Renderer::record`] draws.
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
    pub(super) techniques: Vec<Box<dyn ShadowTechnique>>,
    pub(super) targets: Option<(FrameTargets, wgpu::BindGroup)>,
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
    pub fn add_technique(&mut self, technique: Box<dyn ShadowTechnique>) {
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

    /// Radiance, depth and stencil of the last frame; `None` before the first, or for a frame without pixels.
    pub fn targets(&self) -> Option<&FrameTargets> {
        self.targets.as_ref().map(|(targets, _)| targets)
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

    /// Meshes that are not drawn because the device allows no buffer of their size.
    pub fn oversized_meshes(&self) -> usize {
        self.meshes.oversized
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

    /// What went wrong while the frame was prepared, if anything; such a frame draws nothing.
    pub fn take_failure(&mut self) -> Option<RenderError> {
        self.failure.take()
    }

    /// Makes this frame draw nothing, for what a system between `prepare_objects` and `prepare_draws` could not do.
    pub fn fail(&mut self, failure: RenderError) {
        self.failure.get_or_insert(failure);
    }

    pub(super) fn resize(&mut self, size: UVec2) -> Result<(), RenderError> {
        if self
            .targets
            .as_ref()
            .is_some_and(|(targets, _)| targets.size == size)
        {
            return Ok(());
        }
        self.targets = FrameTargets::new(&self.context, &self.layouts, size)?.map(|targets| {
            let bind_group = self.tonemap.bind(&self.context, &targets.radiance_view);
            (targets, bind_group)
        });
        self.front = None;
        self.masks = None;
        Ok(())
    }

    /// Makes the targets of masks and of the front layer if a light of the frame needs them.
    pub(super) fn require_targets(&mut self) -> Result<(), RenderError> {
        let Some((targets, _)) = &self.targets else {
            return Ok(());
        };
        if self.masks.is_none() && self.frame.lights.iter().any(ActiveLight::has_mask) {
            self.masks = Some(MaskTargets::new(&self.context, &self.layouts, targets)?);
        }
        if self.front.is_none() && self.frame.has_front_layer() {
            self.front = Some(targets.front_layer(&self.context, &self.layouts)?);
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
    context.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("view"),
        layout: &layouts.view,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: view.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: objects.as_entire_binding(),
            },
        ],
    })
}

fn bind_lights(
    context: &RenderContext,
    layouts: &BindGroupLayouts,
    lights: &wgpu::Buffer,
) -> wgpu::BindGroup {
    context.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("lights"),
        layout: &layouts.light,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: lights,
                offset: 0,
                size: std::num::NonZeroU64::new(LIGHT_STRIDE.min(size_of::<gpu_types::Light>() as u64)),
            }),
        }],
    })
}
