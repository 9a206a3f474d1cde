//! The GPU side of a [`Technique`](crate::techniques::Technique): how a shadow technique joins the frame.
//! Nothing here knows the techniques by name.

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

/// The result that a technique leaves of one light, with the part of the technique that leaves it.
#[derive(Clone, Copy)]
pub enum Leaves<'a> {
    /// The stencil counts shadow volumes on top of
    /// [`STENCIL_IN_BOUNDS`](crate::conventions::STENCIL_IN_BOUNDS). A surface is lit where the count is 0.
    Stencil(&'a dyn Mark),
    /// The mask holds visibility. Alpha is the visible share of the whole emitter. Red, green and blue hold,
    /// for each colour, the visible share of that part of the emitter which is above the surface's horizon.
    /// The light pass already leaves out the part below it.
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
    /// The kind of the result, which chooses pipelines.
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

/// Everything that a technique may use while it prepares a frame.
#[derive(Debug)]
pub struct PrepareInput<'a> {
    /// The device and its queue.
    pub context: &'a RenderContext,
    /// The long-lived part that all views share: pipelines, layouts, shaders.
    pub gpu: &'a Gpu,
    /// The meshes of the frame, in GPU buffers.
    pub meshes: &'a MeshPool,
    /// The mesh index and the handedness of each object, by dense object index.
    pub table: &'a ObjectTable,
    /// The size of the targets, texels.
    pub target_size: UVec2,
    /// True if the view mirrors.
    pub mirrored_view: bool,
    /// True if the frame will draw the debug view of this technique.
    pub debug_view: bool,
    /// True if a host adds the lights. It may read the mask at every pixel of a light's scissor, also where it shows
    /// something that is no object of the frame. Otherwise the mask is read where a receiver of the light is shown.
    pub is_hosted: bool,
}

/// Everything that a technique may use while it records.
#[derive(Debug)]
pub struct RecordInput<'a> {
    /// The bind group 0: the view and its objects.
    pub view: &'a wgpu::BindGroup,
    /// The meshes of the frame, in GPU buffers.
    pub meshes: &'a MeshPool,
    /// The materials of the frame, in bind groups. A technique needs them for casters with holes.
    pub materials: &'a MaterialPool,
    /// The meshes and materials of each object, by dense object index.
    pub table: &'a ObjectTable,
    /// The part of the targets that the view covers. A pass begins with the whole of the targets as its
    /// viewport.
    pub viewport: Viewport,
    /// The receivers of the current light, for a technique that draws them.
    pub receivers: Receivers<'a>,
    /// The only objects whose shadows matter, by dense object index; `None` if all matter. A technique may
    /// leave out all other objects.
    pub casters: Option<&'a FixedBitSet>,
}

/// The surfaces that one light lights: its set I, or the blended surfaces of the front layer.
#[derive(Clone, Copy, Debug)]
pub struct Receivers<'a> {
    /// The draws of the receiving surfaces. They include objects that show no shadows
    /// ([`Variant::unshadowed`]).
    ///
    /// [`Variant::unshadowed`]: crate::render::Variant::unshadowed
    pub batches: &'a [Batch],
    /// The meshes, materials and instances that the batches refer to by index.
    pub surfaces: SurfaceResources<'a>,
}

impl Receivers<'_> {
    /// Draws the surfaces that show shadows, with the pipeline that is already set. Its vertex buffers are
    /// [`SURFACE_BUFFERS`]: position, normal, tangent, both sets of texture coordinates, colour, and the
    /// index of the object in group 0. The call sets group 2 to the material.
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

/// Everything that a technique may use while it draws its light-space pictures.
#[derive(Debug)]
pub struct PictureInput<'a> {
    /// The device, for bind groups that are made while recording.
    pub context: &'a RenderContext,
    /// The meshes of the frame, in GPU buffers.
    pub meshes: &'a MeshPool,
    /// The materials of the frame, in bind groups. A technique needs them for casters with holes.
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

/// Everything that a technique may use while it resolves a mask.
#[derive(Debug)]
pub struct ResolveInput<'a> {
    /// The device, for resources that are made while recording.
    pub context: &'a RenderContext,
    /// The input that every recording call of a technique has.
    pub record: RecordInput<'a>,
    /// Depth and stencil of the frame. The depth must not be changed. The stencil is the technique's own.
    pub targets: &'a FrameTargets,
    /// Radiance of the frame, for passes that share pipelines with the light pass. It must not be changed.
    pub radiance: &'a wgpu::TextureView,
    /// The mask to write, and the depth as a texture to read.
    pub masks: &'a MaskTargets,
    /// The rectangle of the light: x, y, width, height, in pixels. Nothing outside of it is read later.
    pub scissor: [u32; 4],
    /// Nearest and farthest depth that the light reaches, 1 ≥ near ≥ far ≥ 0.
    pub depth_range: (f32, f32),
    /// The pass part that clears the stencil and marks the pixels inside the depth range.
    pub light_begin: &'a LightBegin,
    /// The timers of passes. Passes are labelled `<label>/<pass>`.
    pub timings: &'a Timings,
    /// The label of the light.
    pub label: &'a str,
    /// The label of each light, by index into [`FrameLights`](crate::sets::FrameLights).
    pub labels: &'a [String],
}

impl<'a> ResolveInput<'a> {
    /// Returns the input for pictures that a technique draws just before it looks them up.
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
    /// Marks the surfaces that one light does not see. The pass has depth (read-only), stencil, and a
    /// radiance target that must not be written. The scissor is set, and the stencil has been begun.
    fn mark(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput);
}

/// The part of a technique that writes the mask ([`Leaves::Mask`]).
pub trait Resolve {
    /// Records passes that leave the mask of one light, at every pixel of its scissor whose depth is in
    /// range.
    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput);
}

/// The GPU side of a shadow technique. A frame calls, in this order: [`Recorder::prepare`],
/// [`Recorder::draw_pictures`], and, for each light, [`Mark::mark`] or [`Resolve::resolve`] of the part that
/// [`Recorder::light`] returned.
pub trait Recorder: Send + Sync + 'static {
    /// Uploads the data that the frame's lights need. The world holds the sets, silhouettes and the
    /// technique's own data.
    ///
    /// # Errors
    /// Any error of the device or of a shader.
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError>;

    /// Draws the light-space pictures of the lights. It is called once a frame, before all passes on the
    /// screen, however often the pictures are looked up later.
    fn draw_pictures(&self, _encoder: &mut wgpu::CommandEncoder, _input: &PictureInput) {}

    /// Returns the result that this technique leaves for the light at `light` in
    /// [`FrameLights`](crate::sets::FrameLights). It is `None` if another technique shadows the light.
    fn light(&self, light: usize) -> Option<Leaves<'_>>;

    /// Draws the technique's geometry over the picture, as its debug view.
    fn debug(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput);

    /// The number of draw calls that the shadows of one light take.
    fn batch_count(&self, light: usize) -> usize;
}
