//! Maps accumulated radiance to the display's range.
//!
//! Shader  `shaders/passes/tonemap.wgsl`
//! Groups  3 radiance and exposure
//! Reads   radiance.  Writes  the output view
//! Order   last

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::render::gpu::bind_groups::bind_in_order;
use crate::render::gpu::pipeline_cache::{EVERYWHERE, PipelineDesc, Stage, Variants};
use crate::render::gpu::timings::Timings;
use crate::render::{Gpu, RenderError};

/// The pipelines of the tonemap, one for each output format, and the exposure.
#[derive(Debug)]
pub struct Tonemap {
    exposure: wgpu::Buffer,
    pipelines: Variants<wgpu::TextureFormat>,
    /// The format of an output that was not prepared, and so not written, until an output is written.
    unprepared: Mutex<Option<wgpu::TextureFormat>>,
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
            unprepared: Mutex::default(),
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
        self.lock_unprepared().take_if(|unprepared| *unprepared == format);
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

    /// Returns the format of an output that was not written, because it was not prepared. An output that is written ends it.
    pub fn unprepared(&self) -> Option<wgpu::TextureFormat> {
        *self.lock_unprepared()
    }

    fn lock_unprepared(&self) -> MutexGuard<'_, Option<wgpu::TextureFormat>> {
        self.unprepared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records the pass into a view whose format was prepared. Others are not written, and the first is remembered until one
    /// is written.
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
            self.lock_unprepared().get_or_insert(format);
            return;
        };
        self.lock_unprepared().take();
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
