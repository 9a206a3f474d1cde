//! What the passes of a frame draw into: our own textures, or a host's radiance with our depth and stencil.

use super::frame_data::Viewport;
use super::targets::FrameTargets;

/// What the passes of a frame draw into.
#[derive(Clone, Copy, Debug)]
pub struct Canvas<'a> {
    /// Accumulated radiance.
    pub radiance: &'a wgpu::TextureView,
    /// Depth and stencil.
    pub targets: &'a FrameTargets,
    /// The part of them that the view has.
    pub viewport: Viewport,
}

impl<'a> Canvas<'a> {
    /// The pass of one light or of several, which keeps what is there.
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

    /// The radiance as an attachment.
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
