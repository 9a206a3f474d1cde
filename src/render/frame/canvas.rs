//! The targets of a frame's passes: our own textures, or a host's radiance with our depth and stencil.

use super::frame_data::Viewport;
use super::targets::FrameTargets;

/// The targets that the passes of a frame draw into.
#[derive(Clone, Copy, Debug)]
pub struct Canvas<'a> {
    /// The texture of accumulated radiance.
    pub radiance: &'a wgpu::TextureView,
    /// The textures of depth and stencil.
    pub targets: &'a FrameTargets,
    /// The part of the targets that the view covers.
    pub viewport: Viewport,
}

impl<'a> Canvas<'a> {
    /// Begins the pass of one light or of several. It keeps the radiance, depth and stencil that are there.
    pub fn begin_light_pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        label: &str,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites>,
    ) -> wgpu::RenderPass<'e> {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(self.radiance(wgpu::LoadOp::Load))],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.targets.depth_stencil_view,
                depth_ops: None,
                stencil_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Load,
                    store: wgpu::StoreOp::Store,
                }),
            }),
            timestamp_writes,
            ..Default::default()
        });
        self.viewport.set(&mut pass);
        pass
    }

    /// Returns the radiance as a colour attachment.
    pub fn radiance(&self, load: wgpu::LoadOp<wgpu::Color>) -> wgpu::RenderPassColorAttachment<'a> {
        wgpu::RenderPassColorAttachment {
            view: self.radiance,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load,
                store: wgpu::StoreOp::Store,
            },
        }
    }
}
