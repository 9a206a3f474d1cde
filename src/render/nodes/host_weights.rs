//! Draws the weights of objects into a texture of a hosted frame. A host lights pixels without regard to the object that
//! they show, so it reads the weights of each pixel there.
//!
//! Shader  `shaders/passes/host_weights.wgsl`
//! Groups  0 view
//! Reads   depth.  Writes  its own target: the weights of the surface that each pixel shows, 1 where the object has none
//! Order   after `host_depth`, before the lights

use super::pipelines::SURFACE_BUFFERS;
use super::surfaces::{draw_batch, set_mesh};
use crate::render::frame::draw_list::Batch;
use crate::render::frame::recording::Recording;
use crate::render::frame::targets::MASK_FORMAT;
use crate::render::gpu::pipeline_cache::{PipelineDesc, Stage};
use crate::render::{Gpu, RenderError};

/// The pipeline that draws the weights of objects. It draws both sides of a surface, because the depth test selects the
/// side that is shown.
#[derive(Debug)]
pub struct HostWeights {
    pipeline: wgpu::RenderPipeline,
}

impl HostWeights {
    /// Takes the pipeline from the shared cache.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        const FILE: &str = "passes/host_weights.wgsl";
        let desc = PipelineDesc::new(
            "host weights",
            Stage::new(FILE, "vertex"),
            Some(Stage::new(FILE, "fragment")),
        );
        let desc = PipelineDesc {
            buffers: &SURFACE_BUFFERS,
            ..desc
                .with_groups([Some(&gpu.layouts.view)])
                .with_target(MASK_FORMAT, None, wgpu::ColorWrites::ALL)
                .with_depth(
                    gpu.context.depth_stencil_format(),
                    false,
                    wgpu::CompareFunction::Equal,
                    Default::default(),
                )
        };
        Ok(Self {
            pipeline: gpu.pipeline(desc)?,
        })
    }

    /// Clears the target to 1, and records the weights of the objects of `batches`.
    pub fn record(&self, frame: &mut Recording, target: &wgpu::TextureView, batches: &[Batch]) {
        let (view, surfaces, viewport) = (frame.view, frame.surfaces, frame.canvas.viewport);
        let mut pass = frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("host weights"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(frame.canvas.targets.read_only()),
            timestamp_writes: frame.timings.pass("host weights"),
            ..Default::default()
        });
        viewport.set(&mut pass);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, view, &[]);
        for batch in batches {
            let Some(mesh) = surfaces.meshes.get(batch.mesh) else {
                continue;
            };
            set_mesh(&mut pass, mesh, surfaces.instances);
            draw_batch(&mut pass, mesh, batch);
        }
    }
}
