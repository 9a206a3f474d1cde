//! The visibility that the light pass used, as a picture: 0 on shadowed surfaces of the light's set I and on surfaces
//! that were left out of I because the light does not see them, else 1.
//!
//! Shader  `shaders/passes/visibility.wgsl`
//! Groups  0 view, 2 material
//! Reads   depth (equal), stencil (in bounds and count not 0).  Writes  its own target, cleared to 1
//! Order   after the technique marked the light, in place of or beside the light pass

use super::surfaces::{SurfaceResources, draw_batches};
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::draw_list::Batch;
use crate::render::pipelines::SurfacePass;

/// Adds the surfaces that the light does not see.
pub fn record_dark(
    encoder: &mut wgpu::CommandEncoder,
    target: &wgpu::TextureView,
    depth_stencil: &wgpu::TextureView,
    view: &wgpu::BindGroup,
    batches: &[Batch],
    resources: &SurfaceResources,
) {
    let mut pass = begin(encoder, target, depth_stencil, wgpu::LoadOp::Load);
    pass.set_bind_group(0, view, &[]);
    draw_batches(&mut pass, SurfacePass::Dark, batches, resources);
}

fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    target: &wgpu::TextureView,
    depth_stencil: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("visibility"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load,
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth_stencil,
            depth_ops: None,
            stencil_ops: None,
        }),
        ..Default::default()
    })
}

/// Records the draws; `None` for a scissor leaves the target all lit.
pub fn record(
    encoder: &mut wgpu::CommandEncoder,
    target: &wgpu::TextureView,
    depth_stencil: &wgpu::TextureView,
    view: &wgpu::BindGroup,
    scissor: Option<[u32; 4]>,
    batches: &[Batch],
    resources: &SurfaceResources,
) {
    let clear = wgpu::LoadOp::Clear(wgpu::Color::WHITE);
    let mut pass = begin(encoder, target, depth_stencil, clear);
    let Some([x, y, width, height]) = scissor else {
        return;
    };
    pass.set_scissor_rect(x, y, width, height);
    pass.set_stencil_reference(STENCIL_IN_BOUNDS);
    pass.set_bind_group(0, view, &[]);
    draw_batches(&mut pass, SurfacePass::Visibility, batches, resources);
}
