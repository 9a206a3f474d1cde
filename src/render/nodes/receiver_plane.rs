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
use super::surfaces::{SurfaceResources, draw_batches};
use crate::render::frame::draw_list::Batch;
use crate::render::frame::frame_data::Viewport;
use crate::render::frame::targets::{FrameTargets, MaskTargets};
use crate::render::gpu::timings::Timings;

/// What stands where nothing was drawn: no normal packs to it. As in `shaders/common/receiver.wgsl`.
pub const NO_PLANE: u32 = 0x8000_8000;

/// Clears the planes and records the draws of the visible set.
pub fn record(
    encoder: &mut wgpu::CommandEncoder,
    targets: &FrameTargets,
    masks: &MaskTargets,
    viewport: &Viewport,
    view: &wgpu::BindGroup,
    batches: &[Batch],
    resources: &SurfaceResources,
    timings: &Timings,
) {
    let none = f64::from(NO_PLANE);
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
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
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &targets.depth_stencil_view,
            depth_ops: None,
            stencil_ops: None,
        }),
        timestamp_writes: timings.pass("receiver plane"),
        ..Default::default()
    });
    viewport.set(&mut pass);
    pass.set_bind_group(0, view, &[]);
    draw_batches(&mut pass, SurfacePass::ReceiverPlane, batches, resources);
}
