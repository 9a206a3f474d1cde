//! Frames of a stage: their pictures, read back, and their times.

use antumbra::prelude::*;
use antumbra::render::readback::{TexelRows, read_texture};
use antumbra::render::{FrameOutputs, PassTime, RenderError, VISIBILITY_FORMAT, create_target};
use glam::UVec2;

use super::stage::{PICTURE_FORMAT, Stage};

/// Pictures and times of a frame.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// Size of the pictures, pixels.
    pub size: UVec2,
    /// Tonemapped picture, sRGB RGBA.
    pub picture: Vec<u8>,
    /// Radiance, linear RGBA.
    pub radiance: Vec<f32>,
    /// Visibility of each of the stage's lights.
    pub visibility: Vec<Vec<f32>>,
    /// GPU times of the passes; empty if the device has no timers.
    pub pass_times: Vec<PassTime>,
    /// Number of passes too many to be timed.
    pub untimed_passes: usize,
}

impl Rendered {
    fn nothing(size: UVec2, lights: usize) -> Self {
        Self {
            size,
            picture: Vec::new(),
            radiance: Vec::new(),
            visibility: vec![Vec::new(); lights],
            pass_times: Vec::new(),
            untimed_passes: 0,
        }
    }
}

impl Stage {
    /// Runs and draws a frame, and reads back all of its pictures.
    ///
    /// # Errors
    /// Something that the device refuses.
    pub fn render(&mut self) -> Result<Rendered, RenderError> {
        let size = self.world.resource::<ViewportSize>().0;
        let Some(drawn) = self.draw_targets(true)? else {
            return Ok(Rendered::nothing(size, self.lights.len()));
        };
        let indices = self.light_indices();
        let renderer = self.world.resource_mut::<Renderer>();
        let context = renderer.context();
        let visibility = indices
            .iter()
            .map(|index| match index {
                Some(index) => Ok(halves(&read(context, &drawn.visibility[*index], "visibility")?)),
                None => Ok(vec![1.0; size.element_product() as usize]),
            })
            .collect::<Result<Vec<Vec<f32>>, RenderError>>()?;
        let has_view = renderer.targets().is_some();
        let radiance = match renderer.radiance() {
            Some(radiance) => halves(&read(context, &radiance.texture, "radiance")?),
            None => vec![0.0; 4 * size.element_product() as usize],
        };
        Ok(Rendered {
            size,
            picture: read(context, &drawn.picture, "picture")?.bytes,
            radiance,
            visibility,
            pass_times: if has_view {
                renderer.timings().read(context)?
            } else {
                Vec::new()
            },
            untimed_passes: renderer.timings().untimed(),
        })
    }

    /// Runs and draws a frame, and reads back its tonemapped picture alone, sRGB RGBA.
    ///
    /// # Errors
    /// Something that the device refuses.
    pub fn picture(&mut self) -> Result<Vec<u8>, RenderError> {
        let Some(drawn) = self.draw_targets(false)? else {
            return Ok(Vec::new());
        };
        let context = self.world.resource::<Renderer>().context();
        Ok(read(context, &drawn.picture, "picture")?.bytes)
    }

    /// Runs and draws a frame into targets of its own, with those of the visibility if they are asked for. Returns `None` if
    /// the picture has no pixels.
    fn draw_targets(&mut self, with_visibility: bool) -> Result<Option<Drawn>, RenderError> {
        self.run();
        let size = self.world.resource::<ViewportSize>().0;
        let light_count = self.world.resource::<FrameLights>().scene_count();
        let mut renderer = self.world.resource_mut::<Renderer>();
        if let Some(failure) = renderer.take_failure() {
            return Err(failure);
        }
        if size.min_element() == 0 {
            return Ok(None);
        }
        renderer.prepare_output(PICTURE_FORMAT);
        let context = renderer.context().clone();
        let picture = create_target(&context, "picture", size, PICTURE_FORMAT)?;
        let mask_count = if with_visibility { light_count } else { 0 };
        let visibility = (0..mask_count)
            .map(|_| create_target(&context, "visibility", size, VISIBILITY_FORMAT))
            .collect::<Result<Vec<_>, _>>()?;
        let views: Vec<_> = visibility
            .iter()
            .map(|mask| mask.create_view(&Default::default()))
            .collect();
        let mut encoder = context.device.create_command_encoder(&Default::default());
        let picture_view = picture.create_view(&Default::default());
        renderer.record(
            &mut encoder,
            &FrameOutputs {
                picture: Some(&picture_view),
                visibility: &views,
            },
        );
        context.queue.submit([encoder.finish()]);
        Ok(Some(Drawn { picture, visibility }))
    }

    /// Runs and draws a frame, and waits for the device.
    ///
    /// # Errors
    /// Something that the device refuses.
    pub fn draw(&mut self) -> Result<(), RenderError> {
        self.run();
        let mut renderer = self.world.resource_mut::<Renderer>();
        if let Some(failure) = renderer.take_failure() {
            return Err(failure);
        }
        let context = renderer.context();
        let mut encoder = context.device.create_command_encoder(&Default::default());
        renderer.record(&mut encoder, &FrameOutputs::default());
        context.queue.submit([encoder.finish()]);
        let waited = context.device.poll(wgpu::PollType::wait_indefinitely());
        waited.map(|_| ()).map_err(|_| RenderError::DeviceLost)
    }

    /// Returns the bytes of the last frame's radiance, before any tonemap. Pictures are compared by them, bit for
    /// bit.
    ///
    /// # Errors
    /// Something that the device refuses.
    pub fn radiance_bytes(&self) -> Result<Vec<u8>, RenderError> {
        let renderer = self.world.resource::<Renderer>();
        let Some(radiance) = renderer.radiance() else {
            return Ok(Vec::new());
        };
        let all = wgpu::TextureAspect::All;
        Ok(read_texture(renderer.context(), &radiance.texture, all, "radiance")?.bytes)
    }

    /// Runs and draws a frame, and returns only its GPU times.
    ///
    /// # Errors
    /// Something that the device refuses.
    pub fn time_passes(&mut self) -> Result<Vec<PassTime>, RenderError> {
        self.run();
        let mut renderer = self.world.resource_mut::<Renderer>();
        if let Some(failure) = renderer.take_failure() {
            return Err(failure);
        }
        if renderer.targets().is_none() {
            return Ok(Vec::new());
        }
        let context = renderer.context();
        let mut encoder = context.device.create_command_encoder(&Default::default());
        renderer.record(&mut encoder, &FrameOutputs::default());
        context.queue.submit([encoder.finish()]);
        renderer.timings().read(context)
    }
}

/// Targets of a frame.
struct Drawn {
    /// The tonemapped picture.
    picture: wgpu::Texture,
    /// Visibility of each light of the frame; empty if it was not asked for.
    visibility: Vec<wgpu::Texture>,
}

fn read(
    context: &RenderContext,
    texture: &wgpu::Texture,
    name: &'static str,
) -> Result<TexelRows, RenderError> {
    read_texture(context, texture, wgpu::TextureAspect::All, name)
}

fn halves(rows: &TexelRows) -> Vec<f32> {
    rows.bytes
        .chunks_exact(2)
        .map(|bytes| half::f16::from_le_bytes([bytes[0], bytes[1]]).to_f32())
        .collect()
}
