//! Ends of rounds of counting. Between two rounds, pixels that are shadowed so far are taken out of bounds, so
//! that no count of a later round brings them back to 0. After the last round they are put back.
//!
//! Shader  `shaders/passes/light_begin.wgsl`
//! Groups  none
//! Reads   the stencil's count.  Writes  its in-bounds bit
//! Order   between the draws of one light

use crate::conventions::{STENCIL_COUNT_MASK, STENCIL_IN_BOUNDS};
use crate::render::gpu::pipeline_cache::{EVERYWHERE, PipelineDesc, Stage};
use crate::render::gpu::stencil_only::without_color;
use crate::render::{Gpu, RenderError};

/// The pipelines.
#[derive(Debug)]
pub struct Rounds {
    close: wgpu::RenderPipeline,
    reopen: wgpu::RenderPipeline,
}

impl Rounds {
    /// Takes them from the shared cache.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        use wgpu::StencilOperation::{Replace, Zero};
        Ok(Self {
            close: gpu.pipeline(where_counted(gpu, "shadowed in a round", Zero))?,
            reopen: gpu.pipeline(where_counted(gpu, "shadowed in any round", Replace))?,
        })
    }

    /// Ends a round that another one follows.
    pub fn close(&self, pass: &mut wgpu::RenderPass) {
        record(&self.close, pass);
    }

    /// Ends the last of several rounds.
    pub fn reopen(&self, pass: &mut wgpu::RenderPass) {
        record(&self.reopen, pass);
    }
}

fn record(pipeline: &wgpu::RenderPipeline, pass: &mut wgpu::RenderPass) {
    // The reference has count 0, and the test compares only the count of the stencil with it.
    pass.set_stencil_reference(STENCIL_IN_BOUNDS);
    pass.set_pipeline(pipeline);
    pass.draw(0..3, 0..1);
}

/// Describes a pipeline that changes the in-bounds bit where the count is not 0, whatever the depth.
fn where_counted(gpu: &Gpu, label: &'static str, operation: wgpu::StencilOperation) -> PipelineDesc {
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::NotEqual,
        fail_op: wgpu::StencilOperation::Keep,
        depth_fail_op: wgpu::StencilOperation::Keep,
        pass_op: operation,
    };
    let stencil = wgpu::StencilState {
        front: face,
        back: face,
        read_mask: STENCIL_COUNT_MASK,
        write_mask: STENCIL_IN_BOUNDS,
    };
    let format = gpu.context.depth_stencil_format();
    let fragment = Stage::new("passes/light_begin.wgsl", "no_color");
    without_color(PipelineDesc::new(label, EVERYWHERE, Some(fragment))).with_depth(
        format,
        false,
        wgpu::CompareFunction::Always,
        stencil,
    )
}
