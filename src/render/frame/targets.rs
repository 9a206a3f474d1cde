//! The textures that the passes of a frame write.
//!
//! | texture | format | cleared to | written by | read by |
//! | --- | --- | --- | --- | --- |
//! | radiance, or a host's | `Rgba16Float` | background | ambient, light accumulate | tonemap, readback |
//! | depth | [`RenderContext::depth_stencil_format`] | infinity | ambient, or host depth | all later passes |
//! | receiver depth | [`DEPTH_COPY_FORMAT`] | written whole | depth copy | techniques that resolve masks |
//! | receiver plane | [`RECEIVER_PLANE_FORMAT`] | no plane | receiver plane | techniques that ask for it |
//! | front depth and stencil | as depth | copied from depth | front layer | lights of the front layer |
//! | mask | [`MASK_FORMAT`] | by each technique, in the light's scissor | techniques, darker mask | light accumulate, visibility |
//! | companion mask | [`MASK_FORMAT`] | by each technique, in the companion's scissor | techniques | darker mask |
//! | factors | [`MASK_FORMAT`] | 1 | light functions, if the light's shadow has a colour | light accumulate |
//! | stencil | beside the depth | by each light, in its scissor | techniques | light accumulate, visibility |
//!
//! Receiver depth, receiver plane and mask exist from the first frame that has a light with a mask. Front
//! depth and stencil exist from the first frame in which a shadowed light reaches a blended surface.

use glam::UVec2;

use crate::conventions::DEPTH_INFINITY;
use crate::render::gpu::bind_groups::{BindGroupLayouts, bind_in_order};
use crate::render::{RenderContext, RenderError};

/// The format of accumulated radiance.
pub const RADIANCE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The format of the visibility mask of one light ([`Leaves::Mask`](crate::render::recorder::Leaves::Mask)).
/// Half floats have steps of 1/2048 just below 1. Eight bits show bands beside a bright light.
pub const MASK_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The format of the depth that techniques read.
pub const DEPTH_COPY_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// The format of the receivers' planes: the triangle's normal in two 16-bit octahedral coordinates, and the
/// plane's offset as a float's bits.
pub const RECEIVER_PLANE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;

/// The texture of accumulated linear radiance. A frame that a host lights has none of its own.
#[derive(Debug)]
pub struct RadianceTarget {
    /// The texture of radiance.
    pub texture: wgpu::Texture,
    /// The view of the radiance texture.
    pub view: wgpu::TextureView,
}

impl RadianceTarget {
    /// Makes a radiance texture of `size` texels.
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

/// The textures of depth and stencil of one frame size.
#[derive(Debug)]
pub struct FrameTargets {
    /// The size of the textures, texels.
    pub size: UVec2,
    /// The texture of depth and stencil.
    pub depth_stencil: wgpu::Texture,
    /// The view of both depth and stencil.
    pub depth_stencil_view: wgpu::TextureView,
    /// The bind group 3 of passes that read the depth.
    pub depth_group: wgpu::BindGroup,
}

/// Makes a 2D texture with one mip level that can be drawn into, sampled and copied.
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
    /// Makes textures of `size` texels. `label` distinguishes the frame's textures from those of its front
    /// layer.
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
    /// Returns the attachment of a pass that draws the depth of a frame anew.
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

    /// Returns the attachment of a pass that reads depth and stencil.
    pub fn read_only(&self) -> wgpu::RenderPassDepthStencilAttachment<'_> {
        wgpu::RenderPassDepthStencilAttachment {
            view: &self.depth_stencil_view,
            depth_ops: None,
            stencil_ops: None,
        }
    }
}

/// The textures that lights with masks need beside [`FrameTargets`], of the same size. There is one of each,
/// and the lights take turns with them.
#[derive(Debug)]
pub struct MaskTargets {
    /// The copy of the frame's depth. It is made if the mask of a light of the frame is made from it
    /// ([`Needs::draws_receivers`](crate::sets::Needs::draws_receivers)).
    pub receiver_depth: wgpu::Texture,
    /// The view of the copied depth.
    pub receiver_depth_view: wgpu::TextureView,
    /// The planes of the visible triangles. They are drawn if a technique of the frame reads them.
    pub receiver_plane: wgpu::Texture,
    /// The view of the receivers' planes.
    pub receiver_plane_view: wgpu::TextureView,
    /// The bind group 1 of passes that resolve a mask: receiver depth and plane.
    pub receiver_group: wgpu::BindGroup,
    /// The visibility mask of the current light.
    pub mask: wgpu::Texture,
    /// The view of the mask.
    pub mask_view: wgpu::TextureView,
    /// The bind group 3 of passes that read the mask.
    pub mask_group: wgpu::BindGroup,
    /// The mask of the functions that scale the current light, if its shadow has a colour. It exists from the first
    /// frame with such a light.
    pub factors: Option<FactorTarget>,
    /// The weights of the surface that each pixel of a host's picture shows
    /// ([`SurfaceWeights`](crate::scene::SurfaceWeights)). It exists from the first hosted frame with such an object.
    pub surface_weights: Option<wgpu::TextureView>,
    /// The textures that a companion of a light leaves its mask in: these, with another mask. They exist from the first frame
    /// that has a companion.
    pub second: Option<Box<Self>>,
}

/// The texture of the factors of light functions, of the size and format of the mask.
#[derive(Debug)]
pub struct FactorTarget {
    /// The view of the texture.
    pub view: wgpu::TextureView,
    /// The bind group 3 of passes that read the mask and the factors.
    pub group: wgpu::BindGroup,
}

/// Makes a mask, its view, and the bind group of passes that read it.
fn mask(
    context: &RenderContext,
    layouts: &BindGroupLayouts,
    label: &'static str,
    size: UVec2,
) -> Result<(wgpu::Texture, wgpu::TextureView, wgpu::BindGroup), RenderError> {
    let mask = create_target(context, label, size, MASK_FORMAT)?;
    let view = mask.create_view(&Default::default());
    let resource = [wgpu::BindingResource::TextureView(&view)];
    let group = bind_in_order(&context.device, label, &layouts.mask, resource);
    Ok((mask, view, group))
}

impl MaskTargets {
    /// Returns the mask as a colour attachment.
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

    /// Makes the textures for lights with masks, of the size of `targets`.
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
        let (mask, mask_view, mask_group) = mask(context, layouts, "visibility mask", targets.size)?;
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
            mask_group,
            receiver_depth,
            receiver_depth_view,
            receiver_plane,
            receiver_plane_view,
            mask,
            mask_view,
            factors: None,
            surface_weights: None,
            second: None,
        })
    }

    /// Makes the mask of functions if it is missing.
    ///
    /// # Errors
    /// [`RenderError::Limit`] beyond the device's largest texture.
    pub fn require_factors(
        &mut self,
        context: &RenderContext,
        layouts: &BindGroupLayouts,
    ) -> Result<(), RenderError> {
        if self.factors.is_none() {
            let size = UVec2::new(self.mask.width(), self.mask.height());
            let texture = create_target(context, "factors", size, MASK_FORMAT)?;
            let view = texture.create_view(&Default::default());
            let views = [&self.mask_view, &view].map(wgpu::BindingResource::TextureView);
            let group = bind_in_order(&context.device, "masks", &layouts.masks, views);
            self.factors = Some(FactorTarget { view, group });
        }
        Ok(())
    }

    /// Makes the mask of companions if it is missing.
    ///
    /// # Errors
    /// [`RenderError::Limit`] beyond the device's largest texture.
    pub fn require_second(
        &mut self,
        context: &RenderContext,
        layouts: &BindGroupLayouts,
    ) -> Result<(), RenderError> {
        if self.second.is_none() {
            let size = UVec2::new(self.mask.width(), self.mask.height());
            let (mask, mask_view, mask_group) = mask(context, layouts, "companion mask", size)?;
            self.second = Some(Box::new(Self {
                receiver_depth: self.receiver_depth.clone(),
                receiver_depth_view: self.receiver_depth_view.clone(),
                receiver_plane: self.receiver_plane.clone(),
                receiver_plane_view: self.receiver_plane_view.clone(),
                receiver_group: self.receiver_group.clone(),
                mask,
                mask_view,
                mask_group,
                factors: None,
                surface_weights: None,
                second: None,
            }));
        }
        Ok(())
    }

    /// Makes the texture of surfaces' weights.
    pub fn require_surface_weights(&mut self, context: &RenderContext) -> Result<(), RenderError> {
        if self.surface_weights.is_none() {
            let size = UVec2::new(self.mask.width(), self.mask.height());
            let texture = create_target(context, "surface weights", size, MASK_FORMAT)?;
            self.surface_weights = Some(texture.create_view(&Default::default()));
        }
        Ok(())
    }
}
