//! Maps accumulated radiance to the display's range.
//!
//! Shader  `shaders/passes/tonemap.wgsl`
//! Groups  3 radiance and exposure
//! Reads   radiance.  Writes  the output view
//! Order   last

use std::sync::OnceLock;

use crate::render::gpu::bind_groups::bind_in_order;
use crate::render::gpu::pipeline_cache::{EVERYWHERE, PipelineDesc, Stage, Variants};
use crate::render::gpu::timings::Timings;
use crate::render::{Gpu, RenderError};

/// The pipelines of the tonemap, one for each output format, and the exposure.
#[derive(Debug)]
pub struct Tonemap {
    exposure: wgpu::Buffer,
    pipelines: Variants<wgpu::TextureFormat>,
    /// The format of an output that was not prepared, and so not written.
    unprepared: OnceLock<wgpu::TextureFormat>,
}

const FILE: &str = "passes/tonemap.wgsl";

impl Tonemap {
    /// Compiles the shader, and makes the exposure buffer of a view.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        gpu.compile(&[FILE])?;
        Ok(Self {
            exposure: gpu.context.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("exposure"),
                size: 16,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            pipelines: Variants::default(),
            unprepared: OnceLock::new(),
        })
    }

    /// Makes the bind group of one radiance texture.
    pub fn bind(&self, gpu: &Gpu, radiance: &wgpu::TextureView) -> wgpu::BindGroup {
        bind_in_order(
            &gpu.context.device,
            "tonemap",
            &gpu.layouts.tonemap,
            [
                wgpu::BindingResource::TextureView(radiance),
                self.exposure.as_entire_binding(),
            ],
        )
    }

    /// Makes the pipeline of an output format, and writes the exposure, which is a factor on radiance.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        format: wgpu::TextureFormat,
        exposure: f32,
    ) -> Result<(), RenderError> {
        if self.unprepared.get() == Some(&format) {
            self.unprepared.take();
        }
        let exposure = [exposure, 0.0f32, 0.0, 0.0];
        gpu.context
            .queue
            .write_buffer(&self.exposure, 0, bytemuck::cast_slice(&exposure));
        gpu.require(&mut self.pipelines, format, |gpu| {
            PipelineDesc::new("tonemap", EVERYWHERE, Some(Stage::new(FILE, "fragment")))
                .with_groups([None, None, None, Some(&gpu.layouts.tonemap)])
                .with_target(format, None, wgpu::ColorWrites::ALL)
        })
    }

    /// Returns the format of an output that was not written, because it was not prepared.
    pub fn unprepared(&self) -> Option<wgpu::TextureFormat> {
        self.unprepared.get().copied()
    }

    /// Records the pass into a view whose format was prepared. Others are not written, and the first is remembered.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        output: &wgpu::TextureView,
        bind_group: &wgpu::BindGroup,
        timings: &Timings,
    ) {
        let format = output.texture().format();
        // A view may read the texels of its texture as sRGB, or not, and does not tell.
        let others = [format.add_srgb_suffix(), format.remove_srgb_suffix()];
        let mut formats = [format].into_iter().chain(others);
        let Some(pipeline) = formats.find_map(|format| self.pipelines.get(format)) else {
            self.unprepared.get_or_init(|| format);
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
            timestamp_writes: timings.pass("tonemap"),
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(3, bind_group, &[]);
        pass.draw(0..3, 0..1);
    }
}
