//! Pipelines that write the stencil alone, in passes that share an attachment with the light pass.

use crate::render::RenderContext;
use crate::render::frame::targets::RADIANCE_FORMAT;

/// A pipeline that changes the stencil where the depth test passes, and where it fails, by one operation each; both faces
/// alike, whatever the stencil holds. Entry points are `vertex` and `no_color`.
pub fn stencil_by_depth(
    context: &RenderContext,
    label: &str,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
    buffers: &[wgpu::VertexBufferLayout],
    depth_compare: wgpu::CompareFunction,
    [pass_op, depth_fail_op]: [wgpu::StencilOperation; 2],
) -> wgpu::RenderPipeline {
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::Always,
        fail_op: wgpu::StencilOperation::Keep,
        depth_fail_op,
        pass_op,
    };
    context
        .device
        .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(label),
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers,
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: context.depth_stencil_format(),
                depth_write_enabled: Some(false),
                depth_compare: Some(depth_compare),
                stencil: wgpu::StencilState {
                    front: face,
                    back: face,
                    read_mask: 0xff,
                    write_mask: 0xff,
                },
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(no_color(module)),
            multiview_mask: None,
            cache: None,
        })
}

/// A fragment state that writes no colour.
pub fn no_color(module: &wgpu::ShaderModule) -> wgpu::FragmentState<'_> {
    const TARGETS: &[Option<wgpu::ColorTargetState>] = &[Some(wgpu::ColorTargetState {
        format: RADIANCE_FORMAT,
        blend: None,
        write_mask: wgpu::ColorWrites::empty(),
    })];
    wgpu::FragmentState {
        module,
        entry_point: Some("no_color"),
        compilation_options: Default::default(),
        targets: TARGETS,
    }
}
