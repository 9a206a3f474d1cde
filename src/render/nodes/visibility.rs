//! The visibility that the light pass used, as a picture: 0 on shadowed surfaces of the light's set I or what the mask
//! says, and 0 on surfaces that were left out of I because the light does not see them, else 1.
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

/// The shadow of one light.
#[derive(Clone, Copy, Debug)]
pub struct Shadow<'a> {
    /// What the technique left.
    pub kind: SurfacePass,
    /// Group 3, for a mask.
    pub mask: Option<&'a wgpu::BindGroup>,
    /// x, y, width, height; pixels.
    pub scissor: [u32; 4],
    /// What the light lights.
    pub batches: &'a [Batch],
}

/// Adds the surfaces that the light does not see.
pub fn record_dark(frame: &mut Recording, target: &wgpu::TextureView, batches: &[Batch]) {
    let (view, surfaces) = (frame.view, frame.surfaces);
    let mut pass = begin(frame, target, wgpu::LoadOp::Load);
    pass.set_bind_group(0, view, &[]);
    draw_batches(&mut pass, SurfacePass::Dark, batches, &surfaces);
}

/// Clears the target and records the draws; without a shadow it stays all lit.
pub fn record(frame: &mut Recording, target: &wgpu::TextureView, shadow: Option<Shadow>) {
    let (view, surfaces) = (frame.view, frame.surfaces);
    let mut pass = begin(frame, target, wgpu::LoadOp::Clear(wgpu::Color::WHITE));
    if let Some(shadow) = shadow {
        draw(&mut pass, view, &shadow, &[shadow.kind], &surfaces);
    }
}

/// Records the front layer of blended surfaces over what is there.
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
