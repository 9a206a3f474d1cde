//! Pipelines that write the stencil alone, in passes that share an attachment with the light pass.

use super::pipeline_cache::{PipelineDesc, Stage};
use crate::render::RenderContext;
use crate::render::frame::targets::RADIANCE_FORMAT;

/// A pipeline that changes the stencil where the depth test passes, and where it fails, by one operation each; both faces
/// alike, whatever the stencil holds. The fragment stage is `no_color` of `file`.
pub fn stencil_by_depth(
    context: &RenderContext,
    label: &'static str,
    vertex: Stage,
    file: &'static str,
    depth_compare: wgpu::CompareFunction,
    [pass_op, depth_fail_op]: [wgpu::StencilOperation; 2],
) -> PipelineDesc {
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::Always,
        fail_op: wgpu::StencilOperation::Keep,
        depth_fail_op,
        pass_op,
    };
    let stencil = wgpu::StencilState {
        front: face,
        back: face,
        read_mask: 0xff,
        write_mask: 0xff,
    };
    let format = context.depth_stencil_format();
    without_color(PipelineDesc::new(
        label,
        vertex,
        Some(Stage::new(file, "no_color")),
    ))
    .with_depth(format, false, depth_compare, stencil)
}

/// The same with the radiance as a target that is not written.
pub fn without_color(desc: PipelineDesc) -> PipelineDesc {
    desc.with_target(RADIANCE_FORMAT, None, wgpu::ColorWrites::empty())
}
