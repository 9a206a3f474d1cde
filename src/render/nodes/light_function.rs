//! The mask of a light that a function scales: what the technique left of it, times the function.
//!
//! Shaders `shaders/passes/light_function.wgsl`, `shaders/passes/visibility.wgsl` with `lit`; those of the functions
//! Groups  0 view, 2 material
//! Reads   depth, stencil.  Writes  the mask, inside the light's scissor
//! Order   after the technique has marked or resolved the light, before `light_accumulate` of the same light

use super::surface_pass::SurfacePass;
use super::surfaces::draw_batches;
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::frame::draw_list::Batch;
use crate::render::frame::recording::Recording;
use crate::render::frame::targets::{MASK_FORMAT, MaskTargets};
use crate::render::gpu::pipeline_cache::{EVERYWHERE, PipelineDesc, Stage};
use crate::render::nodes::pipelines::stencil_test;
use crate::render::{Gpu, RenderError};

/// The pipeline that makes a mask of a stencil.
#[derive(Debug)]
pub struct StencilToMask {
    pipeline: wgpu::RenderPipeline,
}

impl StencilToMask {
    /// Takes it from the shared cache.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let fragment = Stage::new("passes/light_function.wgsl", "lit");
        let desc = PipelineDesc::new("stencil to mask", EVERYWHERE, Some(fragment))
            .with_target(MASK_FORMAT, None, wgpu::ColorWrites::ALL)
            .with_depth(
                gpu.context.depth_stencil_format(),
                false,
                wgpu::CompareFunction::Always,
                stencil_test(wgpu::CompareFunction::Equal, 0xff),
            );
        Ok(Self {
            pipeline: gpu.pipeline(desc)?,
        })
    }

    /// Records the pass: 1 where the stencil that was marked says lit, 0 elsewhere.
    pub fn record(&self, frame: &mut Recording, masks: &MaskTargets, scissor: [u32; 4]) {
        let mut pass = begin(
            frame,
            masks,
            wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
            scissor,
        );
        pass.set_stencil_reference(STENCIL_IN_BOUNDS);
        pass.set_pipeline(&self.pipeline);
        pass.draw(0..3, 0..1);
    }
}

/// Clears the mask to 1: nothing shadows the light.
pub fn clear(frame: &mut Recording, masks: &MaskTargets, scissor: [u32; 4]) {
    begin(frame, masks, wgpu::LoadOp::Clear(wgpu::Color::WHITE), scissor);
}

/// Writes 1 at the surfaces among `batches` that show no shadows.
pub fn record_unshadowed(frame: &mut Recording, masks: &MaskTargets, scissor: [u32; 4], batches: &[Batch]) {
    if !batches.iter().any(|batch| batch.variant.unshadowed) {
        return;
    }
    let (view, surfaces, viewport) = (frame.view, frame.surfaces, frame.canvas.viewport);
    let mut pass = begin(frame, masks, wgpu::LoadOp::Load, scissor);
    viewport.set(&mut pass);
    pass.set_bind_group(0, view, &[]);
    for batch in batches.iter().filter(|batch| batch.variant.unshadowed) {
        draw_batches(
            &mut pass,
            SurfacePass::WholeMask,
            std::slice::from_ref(batch),
            &surfaces,
        );
    }
}

/// Begins a pass on the mask, with depth and stencil to be tested.
fn begin<'e>(
    frame: &'e mut Recording,
    masks: &MaskTargets,
    load: wgpu::LoadOp<wgpu::Color>,
    [x, y, width, height]: [u32; 4],
) -> wgpu::RenderPass<'e> {
    let mut pass = frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("mask"),
        color_attachments: &[Some(masks.attachment(load))],
        depth_stencil_attachment: Some(frame.canvas.targets.read_only()),
        ..Default::default()
    });
    pass.set_scissor_rect(x, y, width, height);
    pass
}
