//! Copies the frame's depth into a colour texture: wgpu lets no pass read the depth of a texture whose stencil it
//! writes, and techniques that resolve a mask do both.
//!
//! Shader  `shaders/passes/depth_copy.wgsl`
//! Groups  3 depth
//! Reads   depth.  Writes  receiver depth
//! Order   after `ambient`, once a frame; left out when no light of the frame has a mask

use crate::render::targets::{DEPTH_COPY_FORMAT, FrameTargets, MaskTargets};
use crate::render::timings::Timings;
use crate::render::{RenderContext, RenderError, Shaders};

/// The pipeline.
#[derive(Debug)]
pub struct DepthCopy {
    pipeline: wgpu::RenderPipeline,
    group_layout: wgpu::BindGroupLayout,
}

impl DepthCopy {
    /// Builds it.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(context: &RenderContext, shaders: &Shaders) -> Result<Self, RenderError> {
        let device = &context.device;
        let module = shaders.module(device, "passes/depth_copy.wgsl")?;
        let group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("depth copy"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Depth,
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                count: None,
            }],
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("depth copy"),
            bind_group_layouts: &[None, None, None, Some(&group_layout)],
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
        Ok(Self {
            pipeline,
            group_layout,
        })
    }

    /// The bind group of one depth texture.
    pub fn bind(&self, context: &RenderContext, targets: &FrameTargets) -> wgpu::BindGroup {
        let depth = targets.depth_stencil.create_view(&wgpu::TextureViewDescriptor {
            label: Some("depth"),
            aspect: wgpu::TextureAspect::DepthOnly,
            ..Default::default()
        });
        context.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("depth copy"),
            layout: &self.group_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&depth),
            }],
        })
    }

    /// Records the copy.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, masks: &MaskTargets, timings: &Timings) {
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
        pass.set_bind_group(3, &masks.depth_group, &[]);
        pass.draw(0..3, 0..1);
    }
}
