//! How a shadow technique joins the frame: the GPU side of a [`Technique`](crate::techniques::Technique). Nothing here knows
//! the techniques by name.

use bevy_ecs::prelude::World;
use fixedbitset::FixedBitSet;
use glam::UVec2;

use super::frame::draw_list::Batch;
use super::frame::frame_data::Viewport;
use super::frame::targets::{FrameTargets, MaskTargets};
use super::gpu::timings::Timings;
use super::nodes::light_begin::LightBegin;
use super::nodes::surfaces::{SurfaceResources, draw_batch, set_mesh};
use super::pools::materials::MaterialPool;
use super::pools::meshes::MeshPool;
use super::pools::objects::ObjectTable;
use super::{Gpu, RenderContext, RenderError};

/// What a technique leaves of one light, and which part of the technique leaves it.
#[derive(Clone, Copy)]
pub enum Leaves<'a> {
    /// The stencil counts shadow volumes over [`STENCIL_IN_BOUNDS`](crate::conventions::STENCIL_IN_BOUNDS): a surface is
    /// lit where the count is 0.
    Stencil(&'a dyn Mark),
    /// The mask holds visibility. Alpha is the visible share of the whole emitter. Red, green and blue are, by colour, the
    /// visible share of that part of the emitter which is above the surface's horizon; the light pass already leaves out the
    /// part below it.
    Mask(&'a dyn Resolve),
}

/// The kind of [`Leaves`], without the part of the technique that leaves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ShadowKind {
    /// The technique counts in the stencil.
    Stencil,
    /// The technique writes the mask.
    Mask,
}

impl Leaves<'_> {
    /// The kind, for choosing pipelines.
    pub fn kind(&self) -> ShadowKind {
        match self {
            Self::Stencil(_) => ShadowKind::Stencil,
            Self::Mask(_) => ShadowKind::Mask,
        }
    }
}

impl std::fmt::Debug for Leaves<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.kind().fmt(f)
    }
}

/// What a technique may use while it prepares.
#[derive(Debug)]
pub struct PrepareInput<'a> {
    /// The device.
    pub context: &'a RenderContext,
    /// What all views share: pipelines, layouts, shaders.
    pub gpu: &'a Gpu,
    /// Meshes in buffers.
    pub meshes: &'a MeshPool,
    /// Mesh index and handedness by dense object index.
    pub table: &'a ObjectTable,
    /// Texels of the targets.
    pub target_size: UVec2,
    /// The view mirrors.
    pub mirrored_view: bool,
    /// The light pass will draw the debug view of this technique.
    pub debug_view: bool,
}

/// What a technique may use while it records.
#[derive(Debug)]
pub struct RecordInput<'a> {
    /// Group 0.
    pub view: &'a wgpu::BindGroup,
    /// Meshes in buffers.
    pub meshes: &'a MeshPool,
    /// Materials in bind groups, for casters with holes.
    pub materials: &'a MaterialPool,
    /// Meshes and materials by dense object index.
    pub table: &'a ObjectTable,
    /// The part of the targets that the view has. A pass begins with all of them.
    pub viewport: Viewport,
    /// The receivers of the light at hand, for a technique that draws them.
    pub receivers: Receivers<'a>,
    /// Objects of which alone shadows matter, by dense index; `None`: all. A technique may leave others out.
    pub casters: Option<&'a FixedBitSet>,
}

/// The surfaces that one light lights: its set I, or the blended surfaces of the front layer.
#[derive(Clone, Copy, Debug)]
pub struct Receivers<'a> {
    /// Their draws, and among them those of objects that show no shadows ([`Variant::unshadowed`]).
    ///
    /// [`Variant::unshadowed`]: crate::render::Variant::unshadowed
    pub batches: &'a [Batch],
    /// What the batches refer to.
    pub surfaces: SurfaceResources<'a>,
}

impl Receivers<'_> {
    /// Draws those that show shadows with the pipeline that is set, whose vertex buffers are [`SURFACE_BUFFERS`]: position,
    /// normal, tangent, both sets of texture coordinates, colour, and the index of the object in group 0. Sets group 2 to
    /// the material.
    ///
    /// [`SURFACE_BUFFERS`]: crate::render::SURFACE_BUFFERS
    pub fn draw(&self, pass: &mut wgpu::RenderPass) {
        for batch in self.batches.iter().filter(|batch| !batch.variant.unshadowed) {
            let surfaces = &self.surfaces;
            let (Some(mesh), Some(material)) = (
                surfaces.meshes.get(batch.mesh),
                surfaces.materials.get(batch.material),
            ) else {
                continue;
            };
            pass.set_bind_group(2, &material.bind_group, &[]);
            set_mesh(pass, mesh, surfaces.instances);
            draw_batch(pass, mesh, batch);
        }
    }
}

/// What a technique may use while it draws its light-space pictures.
#[derive(Debug)]
pub struct PictureInput<'a> {
    /// The device, for bind groups that are made while recording.
    pub context: &'a RenderContext,
    /// Meshes in buffers.
    pub meshes: &'a MeshPool,
    /// Materials in bind groups, for casters with holes.
    pub materials: &'a MaterialPool,
    /// The timers of passes.
    pub timings: &'a Timings,
    /// The label of each light, by index into [`FrameLights`](crate::sets::FrameLights).
    pub labels: &'a [String],
}

impl PictureInput<'_> {
    /// The label of one light.
    pub fn label(&self, light: usize) -> &str {
        self.labels.get(light).map_or("light", String::as_str)
    }
}

/// What a technique may use while it resolves a mask.
#[derive(Debug)]
pub struct ResolveInput<'a> {
    /// The device, for what is made anew while it is recorded.
    pub context: &'a RenderContext,
    /// What every recorder has.
    pub record: RecordInput<'a>,
    /// Depth and stencil of the frame; the depth must stay as it is, the stencil is the technique's own.
    pub targets: &'a FrameTargets,
    /// Radiance of the frame, for passes that share pipelines with the light's; it must stay as it is.
    pub radiance: &'a wgpu::TextureView,
    /// The mask to write, and the depth as a texture to read.
    pub masks: &'a MaskTargets,
    /// x, y, width, height, pixels: nothing outside is looked at.
    pub scissor: [u32; 4],
    /// Nearest and farthest depth that the light reaches, 1 ≥ near ≥ far ≥ 0.
    pub depth_range: (f32, f32),
    /// Clears the stencil and marks the pixels inside the depth range.
    pub light_begin: &'a LightBegin,
    /// For the passes' timestamps; passes are labelled `<label>/<pass>`.
    pub timings: &'a Timings,
    /// The label of the light.
    pub label: &'a str,
    /// The label of each light, by index into [`FrameLights`](crate::sets::FrameLights).
    pub labels: &'a [String],
}

impl<'a> ResolveInput<'a> {
    /// The same for pictures that are drawn just before they are looked up.
    pub fn pictures(&self) -> PictureInput<'a> {
        PictureInput {
            context: self.context,
            meshes: self.record.meshes,
            materials: self.record.materials,
            timings: self.timings,
            labels: self.labels,
        }
    }
}

/// The part of a technique that counts in the stencil ([`Leaves::Stencil`]).
pub trait Mark {
    /// Marks what one light does not see. The pass has depth (read-only), stencil, and a radiance target that must not be
    /// written; the scissor is set and the stencil begun.
    fn mark(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput);
}

/// The part of a technique that writes the mask ([`Leaves::Mask`]).
pub trait Resolve {
    /// Records passes that leave the mask of one light, at every pixel of its scissor whose depth is in range.
    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput);
}

/// The GPU side of a shadow technique. A frame calls, in this order: [`Recorder::prepare`], [`Recorder::draw_pictures`], and
/// for each light [`Mark::mark`] or [`Resolve::resolve`] of what [`Recorder::light`] gave.
pub trait Recorder: Send + Sync + 'static {
    /// Uploads what the frame's lights need. The world holds the sets, silhouettes and the technique's own data.
    ///
    /// # Errors
    /// Whatever the device refuses.
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError>;

    /// Draws the pictures that lights see: once a frame, before anything of the screen, however many times their lookup
    /// follows.
    fn draw_pictures(&self, _encoder: &mut wgpu::CommandEncoder, _input: &PictureInput) {}

    /// What this technique leaves for the light at `light` in [`FrameLights`](crate::sets::FrameLights); `None` if another
    /// technique shadows the light.
    fn light(&self, light: usize) -> Option<Leaves<'_>>;

    /// Draws the technique's geometry over the picture: its debug view.
    fn debug(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput);

    /// The number of draw calls that the shadows of one light take.
    fn batch_count(&self, light: usize) -> usize;
}
