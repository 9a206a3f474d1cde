//! How a shadow technique joins the frame: the GPU side of a [`Technique`](crate::techniques::Technique). Nothing here knows
//! the techniques by name.

use bevy_ecs::prelude::World;
use fixedbitset::FixedBitSet;
use glam::UVec2;

use super::frame::frame_data::Viewport;
use super::frame::targets::{FrameTargets, MaskTargets};
use super::gpu::bind_groups::BindGroupLayouts;
use super::gpu::timings::Timings;
use super::nodes::light_begin::LightBegin;
use super::pools::materials::MaterialPool;
use super::pools::meshes::MeshPool;
use super::pools::objects::ObjectTable;
use super::{RenderContext, RenderError, Shaders};

/// What a technique leaves of one light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaves {
    /// The stencil counts shadow volumes over [`STENCIL_IN_BOUNDS`](crate::conventions::STENCIL_IN_BOUNDS): lit
    /// where the count is 0.
    Stencil,
    /// The mask holds visibility: of the emitter's area in a; by colour in rgb, where a technique that takes light below the
    /// surface's horizon for hidden gives the share of what is above, for the light pass cuts areas there itself.
    Mask,
}

/// What a technique may use while it prepares.
#[derive(Debug)]
pub struct PrepareInput<'a> {
    /// The device.
    pub context: &'a RenderContext,
    /// Shader composition.
    pub shaders: &'a Shaders,
    /// The layouts that passes share.
    pub layouts: &'a BindGroupLayouts,
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
    /// Objects of which alone shadows matter, by dense index; `None`: all. A technique may leave others out.
    pub casters: Option<&'a FixedBitSet>,
}

/// What a technique may use while it resolves a mask.
#[derive(Debug)]
pub struct ResolveInput<'a> {
    /// The device, for what is made anew while it is recorded.
    pub context: &'a RenderContext,
    /// What every recorder has.
    pub record: RecordInput<'a>,
    /// For bind groups of the frame's textures.
    pub device: &'a wgpu::Device,
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
    /// Label of the light.
    pub label: &'a str,
}

/// The GPU side of a shadow technique.
pub trait Recorder: Send + Sync + 'static {
    /// Uploads what the frame's lights need. The world holds the sets, silhouettes and the technique's own data.
    ///
    /// # Errors
    /// Whatever the device refuses.
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError>;

    /// What this technique will leave for the light at `light` in [`FrameLights`](crate::sets::FrameLights);
    /// `None` if the light is not its own.
    fn visibility(&self, light: usize) -> Option<Leaves>;

    /// For [`Leaves::Stencil`]: marks what one light does not see. The pass has depth (read-only), stencil, and a
    /// radiance target that must not be written; the scissor is set and the stencil begun.
    fn mark(&self, _light: usize, _pass: &mut wgpu::RenderPass, _input: &RecordInput) {}

    /// For [`Leaves::Mask`]: records passes that leave the mask of one light, at every pixel of its scissor whose
    /// depth is in range.
    fn resolve(&self, _light: usize, _encoder: &mut wgpu::CommandEncoder, _input: &ResolveInput) {}

    /// Draws the technique's geometry over the picture: its debug view.
    fn debug(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput);

    /// Draw calls of [`Recorder::mark`] or [`Recorder::resolve`] for one light.
    fn batch_count(&self, light: usize) -> usize;
}
