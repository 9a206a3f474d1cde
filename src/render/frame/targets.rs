//! The frame's textures.
//!
//! | texture | format | cleared to | written by | read by |
//! | --- | --- | --- | --- | --- |
//! | radiance, or a host's | `Rgba16Float` | background | ambient, light accumulate | tonemap, readback |
//! | depth | [`RenderContext::depth_stencil_format`] | infinity | ambient, or host depth | all later passes |
//! | receiver depth | [`DEPTH_COPY_FORMAT`] | written whole | depth copy | techniques that resolve masks |
//! | receiver plane | [`RECEIVER_PLANE_FORMAT`] | no plane | receiver plane | techniques that ask for it |
//! | front depth and stencil | as depth | copied from depth | front layer | lights of the front layer |
//! | mask | [`MASK_FORMAT`] | by each technique, in the light's scissor | techniques | light accumulate, visibility |
//! | stencil | beside the depth | by each light, in its scissor | techniques | light accumulate, visibility |
//!
//! Receiver depth, receiver plane and mask exist from the first frame on that has a light with a mask, the front layer's
//! from the first in which a shadowed light reaches a blended surface.

use glam::UVec2;

use crate::conventions::DEPTH_INFINITY;
use crate::render::gpu::bind_groups::{BindGroupLayouts, bind_in_order};
use crate::render::{RenderContext, RenderError};

/// Format of the accumulated radiance.
pub const RADIANCE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Format of the visibility mask of one light ([`Leaves::Mask`](crate::render::recorder::Leaves::Mask)). Half floats: 1 has 2048
/// steps below it, while eight bits show bands beside a bright light.
pub const MASK_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Format of the depth that techniques read.
pub const DEPTH_COPY_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// Format of the receivers' planes: the triangle's normal in two 16-bit octahedral coordinates, and the plane's offset
/// as a float's bits.
pub const RECEIVER_PLANE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;

/// Accumulated linear radiance. A frame that a host lights has none of its own.
#[derive(Debug)]
pub struct RadianceTarget {
    /// The texture.
    pub texture: wgpu::Texture,
    /// Its view.
    pub view: wgpu::TextureView,
}

impl RadianceTarget {
    /// A texture of `size`.
    ///
    /// # Errors
    /// [`RenderError::Limit`] beyond the device's largest texture.
    pub fn new(context: &RenderContext, size: UVec2) -> Result<Self, RenderError> {
        let texture = create_target(context, "radiance", size, RADIANCE_FORMAT)?;
        Ok(Self {
            view: texture.create_view(&Default::default()),
            texture,
        })
    }
}

/// Depth and stencil of one frame size.
#[derive(Debug)]
pub struct FrameTargets {
    /// Texels.
    pub size: UVec2,
    /// Depth and stencil.
    pub depth_stencil: wgpu::Texture,
    /// Its view.
    pub depth_stencil_view: wgpu::TextureView,
    /// Group 3 of passes that read the depth.
    pub depth_group: wgpu::BindGroup,
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
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    }))
}

impl FrameTargets {
    /// Textures of `size`; `label` tells those of the frame from those of its front layer.
    ///
    /// # Errors
    /// [`RenderError::Limit`] beyond the device's largest texture.
    pub fn new(
        context: &RenderContext,
        layouts: &BindGroupLayouts,
        label: &'static str,
        size: UVec2,
    ) -> Result<Self, RenderError> {
        let depth_stencil = create_target(context, label, size, context.depth_stencil_format())?;
        let depth = depth_stencil.create_view(&wgpu::TextureViewDescriptor {
            label: Some("depth"),
            aspect: wgpu::TextureAspect::DepthOnly,
            ..Default::default()
        });
        Ok(Self {
            size,
            depth_stencil_view: depth_stencil.create_view(&Default::default()),
            depth_group: bind_in_order(
                &context.device,
                "depth",
                &layouts.depth,
                [wgpu::BindingResource::TextureView(&depth)],
            ),
            depth_stencil,
        })
    }
}

impl FrameTargets {
    /// The attachment of a pass that draws the depth of a frame anew.
    pub fn cleared(&self) -> wgpu::RenderPassDepthStencilAttachment<'_> {
        wgpu::RenderPassDepthStencilAttachment {
            view: &self.depth_stencil_view,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(DEPTH_INFINITY),
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(0),
                store: wgpu::StoreOp::Store,
            }),
        }
    }

    /// The attachment of a pass that reads depth and stencil.
    pub fn read_only(&self) -> wgpu::RenderPassDepthStencilAttachment<'_> {
        wgpu::RenderPassDepthStencilAttachment {
            view: &self.depth_stencil_view,
            depth_ops: None,
            stencil_ops: None,
        }
    }
}

/// What lights with masks need beside [`FrameTargets`], of the same size. One of each for all lights, which take turns.
#[derive(Debug)]
pub struct MaskTargets {
    /// Depth of the frame.
    pub receiver_depth: wgpu::Texture,
    /// Its view.
    pub receiver_depth_view: wgpu::TextureView,
    /// Planes of the triangles that are seen; drawn if a technique of the frame reads them.
    pub receiver_plane: wgpu::Texture,
    /// Its view.
    pub receiver_plane_view: wgpu::TextureView,
    /// Group 1 of passes that resolve a mask: receiver depth and plane.
    pub receiver_group: wgpu::BindGroup,
    /// Visibility mask of the light at hand.
    pub mask: wgpu::Texture,
    /// Its view.
    pub mask_view: wgpu::TextureView,
    /// Group 3 of passes that read the mask.
    pub mask_group: wgpu::BindGroup,
}

impl MaskTargets {
    /// The mask as an attachment.
    pub fn attachment(&self, load: wgpu::LoadOp<wgpu::Color>) -> wgpu::RenderPassColorAttachment<'_> {
        wgpu::RenderPassColorAttachment {
            view: &self.mask_view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load,
                store: wgpu::StoreOp::Store,
            },
        }
    }

    /// Textures beside `targets`.
    ///
    /// # Errors
    /// [`RenderError::Limit`] beyond the device's largest texture.
    pub fn new(
        context: &RenderContext,
        layouts: &BindGroupLayouts,
        targets: &FrameTargets,
    ) -> Result<Self, RenderError> {
        let receiver_depth = create_target(context, "receiver depth", targets.size, DEPTH_COPY_FORMAT)?;
        let receiver_plane = create_target(context, "receiver plane", targets.size, RECEIVER_PLANE_FORMAT)?;
        let mask = create_target(context, "visibility mask", targets.size, MASK_FORMAT)?;
        let mask_view = mask.create_view(&Default::default());
        let receiver_depth_view = receiver_depth.create_view(&Default::default());
        let receiver_plane_view = receiver_plane.create_view(&Default::default());
        let receiver_group = bind_in_order(
            &context.device,
            "receiver",
            &layouts.receiver,
            [
                wgpu::BindingResource::TextureView(&receiver_depth_view),
                wgpu::BindingResource::TextureView(&receiver_plane_view),
            ],
        );
        Ok(Self {
            receiver_group,
            mask_group: bind_in_order(
                &context.device,
                "mask",
                &layouts.mask,
                [wgpu::BindingResource::TextureView(&mask_view)],
            ),
            receiver_depth,
            receiver_depth_view,
            receiver_plane,
            receiver_plane_view,
            mask,
            mask_view,
        })
    }
}
