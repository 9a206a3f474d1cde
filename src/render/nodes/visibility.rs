//! The picture of the visibility that the light pass used. It is 0 on shadowed surfaces of the light's set I,
//! or the value of the mask there. It is also 0 on surfaces that I leaves out because the light does not see
//! them. It is 1 elsewhere.
//!
//! Shader  `shaders/passes/visibility.wgsl`
//! Groups  0 view, 2 material, 3 mask
//! Reads   depth (equal), and the stencil (in bounds and count not 0) or the mask.  Writes  its own target, cleared to 1
//! Order   after the technique marked the light, in place of or beside the light pass

use super::surface_pass::SurfacePass;
use super::surfaces::{SurfaceResources, draw_batches};
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::frame::draw_list::Batch;
use crate::render::frame::recording::Recording;

/// The shadow of one light, for the picture of its visibility.
#[derive(Clone, Copy, Debug)]
pub struct Shadow<'a> {
    /// The pass that shows the result of the light's technique.
    pub kind: SurfacePass,
    /// The bind group 3 of the mask, for a light with a mask.
    pub mask: Option<&'a wgpu::BindGroup>,
    /// Rectangle of the light: x, y, width, height, in pixels.
    pub scissor: [u32; 4],
    /// The surfaces that the light lights.
    pub batches: &'a [Batch],
}

/// Draws the surfaces that the light does not see, with a visibility of 0.
pub fn record_dark(frame: &mut Recording, target: &wgpu::TextureView, batches: &[Batch]) {
    let (view, surfaces) = (frame.view, frame.surfaces);
    let mut pass = begin(frame, target, wgpu::LoadOp::Load);
    pass.set_bind_group(0, view, &[]);
    draw_batches(&mut pass, SurfacePass::Dark, batches, &surfaces);
}

/// Clears the target to 1 and draws the shadow. Without a shadow the target stays at 1.
pub fn record(frame: &mut Recording, target: &wgpu::TextureView, shadow: Option<Shadow>) {
    let (view, surfaces) = (frame.view, frame.surfaces);
    let mut pass = begin(frame, target, wgpu::LoadOp::Clear(wgpu::Color::WHITE));
    if let Some(shadow) = shadow {
        draw(&mut pass, view, &shadow, &[shadow.kind], &surfaces);
    }
}

/// Draws the front layer of blended surfaces over the visibility that is there.
pub fn record_front(frame: &mut Recording, target: &wgpu::TextureView, shadow: Shadow) {
    let (view, surfaces) = (frame.view, frame.surfaces);
    let mut pass = begin(frame, target, wgpu::LoadOp::Load);
    let kinds = [SurfacePass::VisibilityFront, shadow.kind];
    draw(&mut pass, view, &shadow, &kinds, &surfaces);
}

fn begin<'e>(
    frame: &'e mut Recording,
    target: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPass<'e> {
    frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
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
        depth_stencil_attachment: Some(frame.canvas.targets.read_only()),
        ..Default::default()
    })
}

fn draw(
    pass: &mut wgpu::RenderPass,
    view: &wgpu::BindGroup,
    shadow: &Shadow,
    kinds: &[SurfacePass],
    resources: &SurfaceResources,
) {
    let [x, y, width, height] = shadow.scissor;
    pass.set_scissor_rect(x, y, width, height);
    pass.set_stencil_reference(STENCIL_IN_BOUNDS);
    pass.set_bind_group(0, view, &[]);
    if let Some(mask) = shadow.mask {
        pass.set_bind_group(3, mask, &[]);
    }
    for &kind in kinds {
        draw_batches(pass, kind, shadow.batches, resources);
    }
}
