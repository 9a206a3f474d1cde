//! From accumulated radiance to the display's range.
//!
//! Shader  `shaders/passes/tonemap.wgsl`
//! Groups  3 radiance and exposure
//! Reads   radiance.  Writes  the output view
//! Order   last

use std::collections::HashMap;

use crate::render::gpu::bind_groups::{BindGroupLayouts, bind_in_order};
use crate::render::{RenderContext, RenderError, Shaders};

/// The pipelines, one an output format, and the exposure.
#[derive(Debug)]
pub struct Tonemap {
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    group_layout: wgpu::BindGroupLayout,
    exposure: wgpu::Buffer,
    pipelines: HashMap<wgpu::TextureFormat, wgpu::RenderPipeline>,
}

impl Tonemap {
    /// Compiles the shader.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(
        context: &RenderContext,
        shaders: &Shaders,
        layouts: &BindGroupLayouts,
    ) -> Result<Self, RenderError> {
        Ok(Self {
            module: shaders.module(&context.device, "passes/tonemap.wgsl")?,
            layout: context
                .device
                .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: Some("tonemap"),
                    bind_group_layouts: &[None, None, None, Some(&layouts.tonemap)],
                    immediate_size: 0,
                }),
            group_layout: layouts.tonemap.clone(),
            exposure: context.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("exposure"),
                size: 16,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            pipelines: HashMap::new(),
        })
    }

    /// The bind group of one radiance texture.
    pub fn bind(&self, context: &RenderContext, radiance: &wgpu::TextureView) -> wgpu::BindGroup {
        bind_in_order(
            &context.device,
            "tonemap",
            &self.group_layout,
            [
                wgpu::BindingResource::TextureView(radiance),
                self.exposure.as_entire_binding(),
            ],
        )
    }

    /// Makes the pipeline of an output format, and writes the exposure (a factor on radiance).
    pub fn prepare(&mut self, context: &RenderContext, format: wgpu::TextureFormat, exposure: f32) {
        context.queue.write_buffer(
            &self.exposure,
            0,
            bytemuck::cast_slice(&[exposure, 0.0f32, 0.0, 0.0]),
        );
        let (module, layout) = (&self.module, &self.layout);
        self.pipelines.entry(format).or_insert_with(|| {
            context
                .device
                .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some("tonemap"),
                    layout: Some(layout),
                    vertex: wgpu::VertexState {
                        module,
                        entry_point: Some("vertex"),
                        compilation_options: Default::default(),
                        buffers: &[],
                    },
                    primitive: Default::default(),
                    depth_stencil: None,
                    multisample: Default::default(),
                    fragment: Some(wgpu::FragmentState {
                        module,
                        entry_point: Some("fragment"),
                        compilation_options: Default::default(),
                        targets: &[Some(format.into())],
                    }),
                    multiview_mask: None,
                    cache: None,
                })
        });
    }

    /// Records the pass into a view of a format that was prepared.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        output: &wgpu::TextureView,
        bind_group: &wgpu::BindGroup,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites>,
    ) {
        let Some(pipeline) = self.pipelines.get(&output.texture().format()) else {
            return;
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("tonemap"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: output,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            timestamp_writes,
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(3, bind_group, &[]);
        pass.draw(0..3, 0..1);
    }
}
