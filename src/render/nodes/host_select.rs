//! Takes surfaces that a light does not affect, or does not see, out of what a host adds of it: the host lights pixels, and does not ask
//! whose they are.
//!
//! Shader  `shaders/passes/host_depth.wgsl`, `vertex` and `no_color`
//! Groups  0 view
//! Reads   depth.  Writes  stencil: 0, which is lit by no test
//! Order   after the technique has marked the light, before the host adds it

use super::pipelines::SURFACE_BUFFERS;
use super::surfaces::{SurfaceResources, draw_batch, set_mesh};
use crate::render::frame::draw_list::Batch;
use crate::render::gpu::pipeline_cache::{PipelineDesc, Stage};
use crate::render::gpu::stencil_only::stencil_by_depth;
use crate::render::{Gpu, RenderError};

/// The pipeline. Both sides of a surface are drawn, whichever it shows: depth tells.
#[derive(Debug)]
pub struct HostSelect {
    pipeline: wgpu::RenderPipeline,
}

impl HostSelect {
    /// Takes it from the shared cache.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        const FILE: &str = "passes/host_depth.wgsl";
        let desc = stencil_by_depth(
            &gpu.context,
            "host select",
            Stage::new(FILE, "vertex"),
            FILE,
            wgpu::CompareFunction::Equal,
            [wgpu::StencilOperation::Zero, wgpu::StencilOperation::Keep],
        );
        let desc = PipelineDesc {
            buffers: &SURFACE_BUFFERS,
            ..desc.with_groups([Some(&gpu.layouts.view)])
        };
        Ok(Self {
            pipeline: gpu.pipeline(desc)?,
        })
    }

    /// Records the draws; scissor and viewport are set.
    pub fn record(
        &self,
        pass: &mut wgpu::RenderPass,
        view: &wgpu::BindGroup,
        batches: &[Batch],
        resources: &SurfaceResources,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, view, &[]);
        for batch in batches {
            let Some(mesh) = resources.meshes.get(batch.mesh) else {
                continue;
            };
            set_mesh(pass, mesh, resources.instances);
            draw_batch(pass, mesh, batch);
        }
    }
}
