//! Ambient and emissive light of the visible set V, and the depth of the frame.
//!
//! Shader  `shaders/passes/ambient.wgsl`
//! Groups  0 view, 2 material
//! Reads   nothing.  Writes  radiance, depth; clears both
//! Order   first

use super::surface_pass::SurfacePass;
use super::surfaces::{SurfaceResources, draw_batches};
use crate::conventions::DEPTH_INFINITY;
use crate::render::frame::canvas::Canvas;
use crate::render::frame::draw_list::Batch;
use crate::render::gpu::timings::Timings;

/// Records the pass.
pub fn record(
    encoder: &mut wgpu::CommandEncoder,
    canvas: &Canvas,
    background: wgpu::Color,
    view: &wgpu::BindGroup,
    batches: &[Batch],
    resources: &SurfaceResources,
    timings: &Timings,
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("ambient"),
        color_attachments: &[Some(canvas.radiance(wgpu::LoadOp::Clear(background)))],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &canvas.targets.depth_stencil_view,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(DEPTH_INFINITY),
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(0),
                store: wgpu::StoreOp::Store,
            }),
        }),
        timestamp_writes: timings.pass("ambient"),
        ..Default::default()
    });
    pass.set_bind_group(0, view, &[]);
    draw_batches(&mut pass, SurfacePass::Ambient, batches, resources);
}
