//! Copies the frame's depth into a colour texture: wgpu lets no pass read the depth of a texture whose stencil it
//! writes, and techniques that resolve a mask do both.
//!
//! Shader  `shaders/passes/depth_copy.wgsl`
//! Groups  3 depth
//! Reads   depth.  Writes  receiver depth
//! Order   after `ambient`, and again after the depth of the front layer; left out when no light has a mask

use crate::render::frame::targets::{DEPTH_COPY_FORMAT, FrameTargets, MaskTargets};
use crate::render::gpu::bind_groups::BindGroupLayouts;
use crate::render::gpu::timings::Timings;
use crate::render::{RenderContext, RenderError, Shaders};

/// The pipeline.
#[derive(Debug)]
pub struct DepthCopy {
    pipeline: wgpu::RenderPipeline,
}

impl DepthCopy {
    /// Builds it.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(
        context: &RenderContext,
        shaders: &Shaders,
        layouts: &BindGroupLayouts,
    ) -> Result<Self, RenderError> {
        let device = &context.device;
        let module = shaders.module(device, "passes/depth_copy.wgsl")?;
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("depth copy"),
            bind_group_layouts: &[None, None, None, Some(&layouts.depth)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("depth copy"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: DEPTH_COPY_FORMAT,
                    blend: None,
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        });
        Ok(Self { pipeline })
    }

    /// Records the copy of the depth of `targets`.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &FrameTargets,
        masks: &MaskTargets,
        timings: &Timings,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("depth copy"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &masks.receiver_depth_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            timestamp_writes: timings.pass("depth copy"),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(3, &targets.depth_group, &[]);
        pass.draw(0..3, 0..1);
    }
}
