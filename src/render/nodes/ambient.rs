//! Ambient and emissive light of the visible set V, and the depth of the frame.
//!
//! Shader  `shaders/passes/ambient.wgsl`
//! Groups  0 view, 2 material
//! Reads   nothing.  Writes  radiance, depth; clears both
//! Order   first

use super::surface_pass::SurfacePass;
use super::surfaces::draw_batches;
use crate::render::frame::draw_list::Batch;
use crate::render::frame::recording::Recording;

/// Records the pass.
pub fn record(frame: &mut Recording, background: wgpu::Color, batches: &[Batch]) {
    let mut pass = frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("ambient"),
        color_attachments: &[Some(frame.canvas.radiance(wgpu::LoadOp::Clear(background)))],
        depth_stencil_attachment: Some(frame.canvas.targets.cleared()),
        timestamp_writes: frame.timings.pass("ambient"),
        ..Default::default()
    });
    pass.set_bind_group(0, frame.view, &[]);
    draw_batches(&mut pass, SurfacePass::Ambient, batches, &frame.surfaces);
}
