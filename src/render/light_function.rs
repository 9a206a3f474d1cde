//! How a light model joins the frame: a function scales what a light gives at each surface, whatever its technique.
//!
//! The function is drawn into the mask of the light, by a blend that multiplies. So it works alike in our own frames, in
//! frames of a host, and in Bevy: whoever adds the light multiplies by the mask.

use bevy_ecs::prelude::World;

use super::RenderError;
use super::recorder::{PrepareInput, ResolveInput};

/// Blending that multiplies the mask by what the fragment stage writes.
pub const MULTIPLY: wgpu::BlendState = {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Dst,
        dst_factor: wgpu::BlendFactor::Zero,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState {
        color: component,
        alpha: component,
    }
};

/// Scales what a light gives at each surface: a cookie, a falloff of its own, barn doors.
///
/// A light that is scaled always has a mask: one whose technique counts in the stencil is resolved into it first, and one
/// without a technique begins with a mask of 1. Surfaces that show no shadows are scaled as well. Blended surfaces behind
/// others are not: they have no mask.
pub trait LightFunction: Send + Sync + 'static {
    /// Uploads what the frame's lights need.
    ///
    /// # Errors
    /// Whatever the device refuses.
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError>;

    /// Whether the function scales the light at `light` in [`FrameLights`](crate::sets::FrameLights).
    fn scales(&self, light: usize) -> bool;

    /// Draws the factor over the pixels of one light. The pass has the mask as its only target
    /// ([`MASK_FORMAT`](super::MASK_FORMAT)), and the scissor is set; the pipeline blends by [`MULTIPLY`].
    fn draw(&self, light: usize, pass: &mut wgpu::RenderPass, input: &ResolveInput);
}
