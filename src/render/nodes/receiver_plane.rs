//! Draws the plane of the triangle that each pixel shows, for techniques that ask for it
//! ([`Recorder::reads_planes`](crate::render::recorder::Recorder::reads_planes)).
//!
//! Shader  `shaders/passes/receiver_plane.wgsl`
//! Groups  0 view, 2 material
//! Reads   depth (equal).  Writes  receiver plane
//! Order   after `ambient`, once a frame; left out when no light of the frame needs it
//!
//! Drawn, not taken from the depth buffer: neighbours of a pixel are often of another triangle, and 24 bits of depth
//! place a surface at 100 m only to millimetres.

use super::surface_pass::SurfacePass;
use super::surfaces::draw_batches;
use crate::render::frame::draw_list::Batch;
use crate::render::frame::recording::Recording;
use crate::render::frame::targets::MaskTargets;

/// What stands where nothing was drawn: no normal packs to it. As in `shaders/common/receiver.wgsl`.
pub const NO_PLANE: u32 = 0x8000_8000;

/// Clears the planes and records the draws of the visible set.
pub fn record(frame: &mut Recording, masks: &MaskTargets, batches: &[Batch]) {
    let none = f64::from(NO_PLANE);
    let mut pass = frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("receiver plane"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &masks.receiver_plane_view,
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
        depth_stencil_attachment: Some(frame.canvas.targets.read_only()),
        timestamp_writes: frame.timings.pass("receiver plane"),
        ..Default::default()
    });
    frame.canvas.viewport.set(&mut pass);
    pass.set_bind_group(0, frame.view, &[]);
    draw_batches(&mut pass, SurfacePass::ReceiverPlane, batches, &frame.surfaces);
}
