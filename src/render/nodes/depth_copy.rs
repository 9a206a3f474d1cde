//! Copies the frame's depth into a colour texture. wgpu lets no pass read the depth of a texture whose
//! stencil it writes, and techniques that resolve a mask do both.
//!
//! Shader  `shaders/passes/depth_copy.wgsl`
//! Groups  3 depth
//! Reads   depth.  Writes  receiver depth
//! Order   after `ambient`, and again after the depth of the front layer; left out when no light's mask is made from it

use crate::render::frame::recording::Recording;
use crate::render::frame::targets::{DEPTH_COPY_FORMAT, MaskTargets};
use crate::render::gpu::pipeline_cache::{EVERYWHERE, PipelineDesc, Stage};
use crate::render::{Gpu, RenderError};

/// The pipeline that copies depth.
#[derive(Debug)]
pub struct DepthCopy {
    pipeline: wgpu::RenderPipeline,
}

impl DepthCopy {
    /// Takes the pipeline from the shared cache.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let fragment = Stage::new("passes/depth_copy.wgsl", "fragment");
        let desc = PipelineDesc::new("depth copy", EVERYWHERE, Some(fragment))
            .with_groups([None, None, None, Some(&gpu.layouts.depth)])
            .with_target(DEPTH_COPY_FORMAT, None, wgpu::ColorWrites::ALL);
        Ok(Self {
            pipeline: gpu.pipeline(desc)?,
        })
    }

    /// Records the copy of the recording's current depth.
    pub fn record(&self, frame: &mut Recording, masks: &MaskTargets) {
        let mut pass = frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
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
            timestamp_writes: frame.timings.pass("depth copy"),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(3, &frame.canvas.targets.depth_group, &[]);
        pass.draw(0..3, 0..1);
    }
}
