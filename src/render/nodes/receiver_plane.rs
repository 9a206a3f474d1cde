//! Draws the plane of the triangle that each pixel shows, for techniques that need it (`receiver_planes`
//! among the needs of a technique).
//!
//! Shader  `shaders/passes/receiver_plane.wgsl`
//! Groups  0 view, 2 material
//! Reads   depth (equal).  Writes  receiver plane
//! Order   after the depth copy; left out when no light of the frame needs it
//!
//! The planes are drawn and not computed from the depth buffer, because neighbours of a pixel often belong to
//! another triangle, and 24 bits of depth place a surface at 100 m only to millimetres.

use super::surface_pass::SurfacePass;
use super::surfaces::draw_batches;
use crate::render::frame::canvas::Canvas;
use crate::render::frame::draw_list::Batch;
use crate::render::frame::recording::Recording;

/// The value of pixels where no surface was drawn. No normal packs to it. `shaders/common/receiver.wgsl` has
/// the same constant.
pub const NO_PLANE: u32 = 0x8000_8000;

/// Clears the planes and records the draws of the given surfaces.
pub fn record(frame: &mut Recording, target: &wgpu::TextureView, batches: &[Batch]) {
    let timer = frame.timings.pass("receiver plane");
    let surfaces = frame.surfaces;
    let mut pass = begin(frame.encoder, &frame.canvas, target, timer);
    pass.set_bind_group(0, frame.view, &[]);
    draw_batches(&mut pass, SurfacePass::ReceiverPlane, batches, &surfaces);
}

/// Begins the pass, which clears the planes.
pub fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    canvas: &Canvas,
    target: &wgpu::TextureView,
    timer: Option<wgpu::RenderPassTimestampWrites>,
) -> wgpu::RenderPass<'e> {
    let none = f64::from(NO_PLANE);
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("receiver plane"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color {
                    r: none,
                    g: 0.0,
                    b: 0.0,
                    a: 0.0,
                }),
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: Some(canvas.targets.read_only()),
        timestamp_writes: timer,
        ..Default::default()
    });
    canvas.viewport.set(&mut pass);
    pass
}
