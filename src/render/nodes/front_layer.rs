//! The depth of the nearest surfaces, blended ones included, so that the nearest blended surface of each pixel receives
//! shadows.
//!
//! Shader  `shaders/passes/ambient.wgsl`, `depth_of_blended`
//! Groups  0 view, 2 material
//! Reads   depth.  Writes  front depth
//! Order   after all lights of opaque surfaces; left out when no shadowed light reaches a blended surface
//!
//! A technique finds what a light sees of one surface a pixel: the one in the depth buffer. So blended surfaces get a
//! depth buffer of their own, and each light that reaches them marks or resolves again, for that. Farther blended
//! surfaces are lit without shadows.

use super::surface_pass::SurfacePass;
use super::surfaces::draw_batches;
use crate::render::frame::draw_list::Batch;
use crate::render::frame::recording::Recording;
use crate::render::frame::targets::FrameTargets;

/// Records the copy of the frame's depth into that of `front`, and the draws of the blended batches over it.
pub fn record(frame: &mut Recording, front: &FrameTargets, batches: &[Batch]) {
    let depth = &frame.canvas.targets.depth_stencil;
    frame.encoder.copy_texture_to_texture(
        depth.as_image_copy(),
        front.depth_stencil.as_image_copy(),
        depth.size(),
    );
    let mut pass = frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("front layer"),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &front.depth_stencil_view,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Load,
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Load,
                store: wgpu::StoreOp::Store,
            }),
        }),
        timestamp_writes: frame.timings.pass("front layer"),
        ..Default::default()
    });
    pass.set_bind_group(0, frame.view, &[]);
    draw_batches(&mut pass, SurfacePass::FrontDepth, batches, &frame.surfaces);
}
