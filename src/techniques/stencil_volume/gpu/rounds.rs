//! Between two rounds of counting: what is shadowed so far is taken out of bounds, so that no count of a later round brings
//! it back to 0; at the end it is put back.
//!
//! Shader  `shaders/passes/light_begin.wgsl`
//! Groups  none
//! Reads   the stencil's count.  Writes  its in-bounds bit
//! Order   between the draws of one light

use crate::conventions::{STENCIL_COUNT_MASK, STENCIL_IN_BOUNDS};
use crate::render::gpu::stencil_only::no_color;
use crate::render::{RenderContext, RenderError, Shaders};

/// The pipelines.
#[derive(Debug)]
pub struct Rounds {
    close: wgpu::RenderPipeline,
    reopen: wgpu::RenderPipeline,
}

impl Rounds {
    /// Builds them.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(context: &RenderContext, shaders: &Shaders) -> Result<Self, RenderError> {
        use wgpu::StencilOperation::{Replace, Zero};
        let module = shaders.module(&context.device, "passes/light_begin.wgsl")?;
        Ok(Self {
            close: where_counted(context, &module, "shadowed in a round", Zero),
            reopen: where_counted(context, &module, "shadowed in any round", Replace),
        })
    }

    /// Ends a round that another follows.
    pub fn close(&self, pass: &mut wgpu::RenderPass) {
        record(&self.close, pass);
    }

    /// Ends the last of several rounds.
    pub fn reopen(&self, pass: &mut wgpu::RenderPass) {
        record(&self.reopen, pass);
    }
}

fn record(pipeline: &wgpu::RenderPipeline, pass: &mut wgpu::RenderPass) {
    // Without a count of its own: only the count of the stencil is compared with it.
    pass.set_stencil_reference(STENCIL_IN_BOUNDS);
    pass.set_pipeline(pipeline);
    pass.draw(0..3, 0..1);
}

/// Changes the in-bounds bit where the count is not 0, whatever the depth.
fn where_counted(
    context: &RenderContext,
    module: &wgpu::ShaderModule,
    label: &str,
    operation: wgpu::StencilOperation,
) -> wgpu::RenderPipeline {
    let layout = context
        .device
        .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(label),
            ..Default::default()
        });
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::NotEqual,
        fail_op: wgpu::StencilOperation::Keep,
        depth_fail_op: wgpu::StencilOperation::Keep,
        pass_op: operation,
    };
    context
        .device
        .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: context.depth_stencil_format(),
                depth_write_enabled: Some(false),
                depth_compare: Some(wgpu::CompareFunction::Always),
                stencil: wgpu::StencilState {
                    front: face,
                    back: face,
                    read_mask: STENCIL_COUNT_MASK,
                    write_mask: STENCIL_IN_BOUNDS,
                },
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(no_color(module)),
            multiview_mask: None,
            cache: None,
        })
}
