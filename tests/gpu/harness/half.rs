//! A light function of somebody else: it gives a surface one half of what the light would.

use antumbra::render::{Gpu, LightFunction, MASK_FORMAT, MULTIPLY, PrepareInput, RenderError, ResolveInput};
use bevy_ecs::prelude::World;

const SHADER: &str = "
@vertex
fn vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32((vertex & 1u) << 2u), f32((vertex & 2u) << 1u)) - 1.0, 0.0, 1.0);
}
@fragment
fn fragment() -> @location(0) vec4f { return vec4f(0.5); }
";

/// Halves every light.
pub struct Half {
    pipeline: wgpu::RenderPipeline,
}

impl Half {
    /// Of a device.
    pub fn new(gpu: &Gpu) -> Self {
        let device = &gpu.context.device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let target = wgpu::ColorTargetState {
            format: MASK_FORMAT,
            blend: Some(MULTIPLY),
            write_mask: wgpu::ColorWrites::ALL,
        };
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("half"),
            layout: None,
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
                targets: &[Some(target)],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { pipeline }
    }
}

impl LightFunction for Half {
    fn prepare(&mut self, _: &World, _: &PrepareInput) -> Result<(), RenderError> {
        Ok(())
    }

    fn scales(&self, _: usize) -> bool {
        true
    }

    fn draw(&self, _: usize, pass: &mut wgpu::RenderPass, _: &ResolveInput) {
        pass.set_pipeline(&self.pipeline);
        pass.draw(0..3, 0..1);
    }
}
