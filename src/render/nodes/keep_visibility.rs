//! Keeps the visibility of a light for a host, beyond the light's turn with the stencil and the mask.
//!
//! Shader  `shaders/passes/keep_visibility.wgsl`
//! Groups  3 mask, for a light with a mask; for a light whose shadows have a colour also 1 light, and in 3 its factors
//! Reads   the stencil, and the mask.  Writes  its own target: 0 where the light is not seen
//! Order   after the host has added the light
//!
//! A light whose shadows have a colour or let light pass is kept as the share that diffuse light has of its own colour.
//! The share cannot exceed 1, so a shadow's colour is seen up to the light's.

use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::frame::hosted::stencil_lit;
use crate::render::frame::recording::Recording;
use crate::render::gpu::pipeline_cache::{EVERYWHERE, PipelineDesc, Stage};
use crate::render::{Gpu, RenderError};

/// Format of kept visibility: the share by colour.
pub const KEPT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// The pipelines that keep the visibility of lights.
#[derive(Debug)]
pub struct KeepVisibility {
    lit: wgpu::RenderPipeline,
    masked: wgpu::RenderPipeline,
    tinted: wgpu::RenderPipeline,
}

/// What is known of the visibility of a light, beside the stencil.
#[derive(Clone, Copy, Debug)]
pub enum Known<'a> {
    /// Nothing: the light has no mask.
    Stencil,
    /// The bind group of its mask.
    Mask(&'a wgpu::BindGroup),
    /// The bind groups of its mask and factors, and of the lights with the offset of this one. Its shadow has a colour.
    Tinted(&'a wgpu::BindGroup, (&'a wgpu::BindGroup, u32)),
}

impl KeepVisibility {
    /// Takes the pipelines from the shared cache.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let pipeline = |entry, groups| {
            let fragment = Stage::new("passes/keep_visibility.wgsl", entry);
            let desc = PipelineDesc::new("keep visibility", EVERYWHERE, Some(fragment))
                .with_groups(groups)
                .with_target(KEPT_FORMAT, None, wgpu::ColorWrites::ALL)
                .with_depth(
                    gpu.context.depth_stencil_format(),
                    false,
                    wgpu::CompareFunction::Always,
                    stencil_lit(),
                );
            gpu.pipeline(desc)
        };
        Ok(Self {
            lit: pipeline("lit", [None, None, None, None])?,
            masked: pipeline("masked", [None, None, None, Some(&gpu.layouts.mask)])?,
            tinted: pipeline(
                "tinted",
                [None, Some(&gpu.layouts.light), None, Some(&gpu.layouts.masks)],
            )?,
        })
    }

    /// Clears the target and records the visibility of the light whose stencil and mask are there.
    pub fn record(&self, frame: &mut Recording, target: &wgpu::TextureView, scissor: [u32; 4], known: Known) {
        let mut pass = frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("keep visibility"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(frame.canvas.targets.read_only()),
            timestamp_writes: frame.timings.pass("keep visibility"),
            ..Default::default()
        });
        frame.canvas.viewport.set(&mut pass);
        let [x, y, width, height] = scissor;
        pass.set_scissor_rect(x, y, width, height);
        pass.set_stencil_reference(STENCIL_IN_BOUNDS);
        match known {
            Known::Stencil => pass.set_pipeline(&self.lit),
            Known::Mask(mask) => {
                pass.set_pipeline(&self.masked);
                pass.set_bind_group(3, mask, &[]);
            }
            Known::Tinted(masks, (lights, offset)) => {
                pass.set_pipeline(&self.tinted);
                pass.set_bind_group(1, lights, &[offset]);
                pass.set_bind_group(3, masks, &[]);
            }
        }
        pass.draw(0..3, 0..1);
    }
}
