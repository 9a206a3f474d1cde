//! Takes surfaces that a light does not affect, or does not see, out of what a host adds of it: the host lights pixels, and does not ask
//! whose they are.
//!
//! Shader  `shaders/passes/host_depth.wgsl`, `vertex` and `no_color`
//! Groups  0 view
//! Reads   depth.  Writes  stencil: 0, which is lit by no test
//! Order   after the technique has marked the light, before the host adds it

use crate::render::bind_groups::BindGroupLayouts;
use crate::render::draw_list::Batch;
use crate::render::nodes::light_begin::no_color;
use crate::render::nodes::surfaces::SurfaceResources;
use crate::render::pipelines::SURFACE_BUFFERS;
use crate::render::{RenderContext, RenderError, Shaders};

/// The pipeline. Both sides of a surface are drawn, whichever it shows: depth tells.
#[derive(Debug)]
pub struct HostSelect {
    pipeline: wgpu::RenderPipeline,
}

impl HostSelect {
    /// Builds it.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(
        context: &RenderContext,
        shaders: &Shaders,
        layouts: &BindGroupLayouts,
    ) -> Result<Self, RenderError> {
        let module = shaders.module(&context.device, "passes/host_depth.wgsl")?;
        let layout = context
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("host select"),
                bind_group_layouts: &[Some(&layouts.view)],
                immediate_size: 0,
            });
        let face = wgpu::StencilFaceState {
            compare: wgpu::CompareFunction::Always,
            fail_op: wgpu::StencilOperation::Keep,
            depth_fail_op: wgpu::StencilOperation::Keep,
            pass_op: wgpu::StencilOperation::Zero,
        };
        let pipeline = context
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("host select"),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vertex"),
                    compilation_options: Default::default(),
                    buffers: &SURFACE_BUFFERS,
                },
                primitive: Default::default(),
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: context.depth_stencil_format(),
                    depth_write_enabled: Some(false),
                    depth_compare: Some(wgpu::CompareFunction::Equal),
                    stencil: wgpu::StencilState {
                        front: face,
                        back: face,
                        read_mask: 0xff,
                        write_mask: 0xff,
                    },
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: Some(no_color(&module)),
                multiview_mask: None,
                cache: None,
            });
        Ok(Self { pipeline })
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
            pass.set_vertex_buffer(0, mesh.positions.slice(..));
            pass.set_vertex_buffer(1, mesh.surface.slice(..));
            pass.set_vertex_buffer(2, resources.instances.slice(..));
            pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
            let submesh = mesh.submeshes[batch.submesh as usize];
            let indices = submesh.first_index..submesh.first_index + submesh.index_count;
            pass.draw_indexed(indices, 0, batch.instances.clone());
        }
    }
}
