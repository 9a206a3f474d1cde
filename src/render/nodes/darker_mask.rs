//! Darkens the mask of a light by that of a companion: at each pixel the lesser visibility counts.
//!
//! Shaders `shaders/passes/darker_mask.wgsl`, `darker` and `lit` of `shaders/passes/visibility.wgsl`
//! Groups  0 view, 2 material, 3 the companion's mask
//! Reads   depth.  Writes  the mask, inside the companion's scissor and depth bounds; stencil: that of the bounds
//! Order   after the techniques of both have left their masks, before functions scale the light

use super::light_begin::LightBegin;
use super::pipelines::stencil_test;
use super::surface_pass::SurfacePass;
use super::surfaces::draw_batches;
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::frame::draw_list::Batch;
use crate::render::frame::recording::Recording;
use crate::render::frame::targets::{MASK_FORMAT, MaskTargets};
use crate::render::gpu::pipeline_cache::{EVERYWHERE, LESSER, PipelineDesc, Stage};
use crate::render::{Gpu, RenderError};

/// The pipeline that darkens a mask everywhere.
#[derive(Debug)]
pub struct DarkerMask {
    pipeline: wgpu::RenderPipeline,
}

/// The area that a companion darkens.
#[derive(Clone, Copy, Debug)]
pub struct DarkerArea<'a> {
    /// Rectangle of the companion: x, y, width, height, in pixels of the targets.
    pub scissor: [u32; 4],
    /// Nearest and farthest depth that the companion reaches.
    pub depth_range: (f32, f32),
    /// The label of the companion.
    pub label: &'a str,
}

impl DarkerMask {
    /// Takes the pipeline from the shared cache.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let fragment = Stage::new("passes/darker_mask.wgsl", "darker");
        let desc = PipelineDesc::new("darker mask", EVERYWHERE, Some(fragment))
            .with_groups([None, None, None, Some(&gpu.layouts.mask)])
            .with_target(MASK_FORMAT, Some(LESSER), wgpu::ColorWrites::ALL)
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

    /// Darkens `masks` by the mask of group `by` in the whole area.
    pub fn record(
        &self,
        frame: &mut Recording,
        masks: &MaskTargets,
        by: &wgpu::BindGroup,
        light_begin: &LightBegin,
        area: &DarkerArea,
    ) {
        let mut pass = begin(frame, masks, area);
        // A companion knows nothing beyond its depth bounds.
        let (near, far) = area.depth_range;
        light_begin.record(&mut pass, near, far);
        pass.set_stencil_reference(STENCIL_IN_BOUNDS);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(3, by, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// Darkens `masks` by the mask of group `by` where the surfaces of `batches` are shown.
pub fn record_surfaces(
    frame: &mut Recording,
    masks: &MaskTargets,
    by: &wgpu::BindGroup,
    area: &DarkerArea,
    batches: &[Batch],
) {
    draw(frame, masks, Some(by), SurfacePass::DarkerMask, area, batches);
}

/// Writes 1 into `masks` where the surfaces of `batches` are shown.
pub fn clear_surfaces(frame: &mut Recording, masks: &MaskTargets, area: &DarkerArea, batches: &[Batch]) {
    if !batches.is_empty() {
        draw(frame, masks, None, SurfacePass::WholeMask, area, batches);
    }
}

fn draw(
    frame: &mut Recording,
    masks: &MaskTargets,
    by: Option<&wgpu::BindGroup>,
    kind: SurfacePass,
    area: &DarkerArea,
    batches: &[Batch],
) {
    let (view, surfaces) = (frame.view, frame.surfaces);
    let mut pass = begin(frame, masks, area);
    pass.set_bind_group(0, view, &[]);
    if let Some(by) = by {
        pass.set_bind_group(3, by, &[]);
    }
    draw_batches(&mut pass, kind, batches, &surfaces);
}

/// Begins a pass on a mask with the viewport and scissor of the area.
fn begin<'e>(frame: &'e mut Recording, masks: &MaskTargets, area: &DarkerArea) -> wgpu::RenderPass<'e> {
    let mut pass = frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("darker mask"),
        color_attachments: &[Some(masks.attachment(wgpu::LoadOp::Load))],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &frame.canvas.targets.depth_stencil_view,
            depth_ops: None,
            stencil_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Load,
                store: wgpu::StoreOp::Store,
            }),
        }),
        timestamp_writes: frame.timings.pass_of(area.label, "darker mask"),
        ..Default::default()
    });
    frame.canvas.viewport.set(&mut pass);
    let [x, y, width, height] = area.scissor;
    pass.set_scissor_rect(x, y, width, height);
    pass
}
