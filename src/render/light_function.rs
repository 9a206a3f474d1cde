//! Light functions: how a light model joins the frame. A function scales the radiance that a light gives at
//! each surface, whatever the light's technique.
//!
//! The function is drawn into the mask of the light, by a blend that multiplies. It works alike in our own
//! frames, in frames of a host, and in Bevy, because all of them multiply the light by its mask.

use bevy_ecs::prelude::World;

use super::RenderError;
use super::recorder::{PrepareInput, ResolveInput};

/// The blend state that multiplies the mask by the output of the fragment stage.
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

/// Scales the radiance that a light gives at each surface. Examples are a cookie, a custom falloff, and barn
/// doors.
///
/// A scaled light always has a mask. If the light's technique counts in the stencil, the stencil is first
/// resolved into the mask. If the light has no technique, the mask begins as 1. Surfaces that show no shadows
/// are scaled as well. Blended surfaces behind others are not scaled, because they have no mask.
pub trait LightFunction: Send + Sync + 'static {
    /// Uploads the data that the frame's lights need.
    ///
    /// # Errors
    /// Any error of the device or of a shader.
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError>;

    /// Returns whether the function scales the light at `light` in [`FrameLights`](crate::sets::FrameLights).
    fn scales(&self, light: usize) -> bool;

    /// Draws the factor over the pixels of one light. The mask is the pass's only target
    /// ([`MASK_FORMAT`](super::MASK_FORMAT)), and the scissor is set. The pipeline must blend with
    /// [`MULTIPLY`].
    fn draw(&self, light: usize, pass: &mut wgpu::RenderPass, input: &ResolveInput);
}
