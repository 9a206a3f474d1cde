//! What a recorder is made with.

use crate::render::gpu::bind_groups::BindGroupLayouts;
use crate::render::{RenderContext, Shaders};

/// What a recorder is made with.
#[derive(Clone, Copy, Debug)]
pub struct RecorderInput<'a> {
    /// The device.
    pub context: &'a RenderContext,
    /// Shader composition.
    pub shaders: &'a Shaders,
    /// The layouts that passes share.
    pub layouts: &'a BindGroupLayouts,
}
