//! The frame's textures.
//!
//! | texture | format | cleared to | written by | read by |
//! | --- | --- | --- | --- | --- |
//! | radiance | `Rgba16Float` | background | ambient, light accumulate | tonemap, readback |
//! | depth | [`RenderContext::depth_stencil_format`] | infinity | ambient | all later passes |
//! | stencil | beside the depth | by each light, in its scissor | techniques | light accumulate, visibility |

use glam::UVec2;

use super::{RenderContext, RenderError};

/// Format of the accumulated radiance.
pub const RADIANCE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Textures of one frame size.
#[derive(Debug)]
pub struct FrameTargets {
    /// Texels.
    pub size: UVec2,
    /// Accumulated linear radiance.
    pub radiance: wgpu::Texture,
    /// Its view.
    pub radiance_view: wgpu::TextureView,
    /// Depth and stencil.
    pub depth_stencil: wgpu::Texture,
    /// Its view.
    pub depth_stencil_view: wgpu::TextureView,
}

/// A 2D texture with one mip level that can be drawn into and read back.
///
/// # Errors
/// [`RenderError::Limit`] beyond the device's largest texture.
pub fn create_target(
    context: &RenderContext,
    label: &'static str,
    size: UVec2,
    format: wgpu::TextureFormat,
) -> Result<wgpu::Texture, RenderError> {
    let limit = context.device.limits().max_texture_dimension_2d;
    if size.max_element() > limit {
        return Err(RenderError::Limit {
            what: label,
            needed: u64::from(size.max_element()),
            limit: u64::from(limit),
        });
    }
    Ok(context.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    }))
}

impl FrameTargets {
    /// Textures of `size`; `None` if a side is 0, when there is nothing to draw.
    ///
    /// # Errors
    /// [`RenderError::Limit`] beyond the device's largest texture.
    pub fn new(context: &RenderContext, size: UVec2) -> Result<Option<Self>, RenderError> {
        if size.min_element() == 0 {
            return Ok(None);
        }
        let radiance = create_target(context, "radiance", size, RADIANCE_FORMAT)?;
        let depth_stencil =
            create_target(context, "depth and stencil", size, context.depth_stencil_format())?;
        Ok(Some(Self {
            size,
            radiance_view: radiance.create_view(&Default::default()),
            depth_stencil_view: depth_stencil.create_view(&Default::default()),
            radiance,
            depth_stencil,
        }))
    }
}
