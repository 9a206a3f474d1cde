//! The passes of a frame, in their order. Start reading here.

use std::ops::Range;

use super::canvas::Canvas;
use super::draw_list::Batch;
use super::front_lights::LightSurfaces;
use super::recording::Recording;
use super::targets::FrameTargets;
use crate::render::nodes;
use crate::render::recorder::PictureInput;
use crate::render::renderer::Renderer;

/// The targets of a frame's results, apart from the radiance in the renderer's own targets.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameOutputs<'a> {
    /// The target of the tonemapped picture. Its format must have been prepared
    /// ([`Renderer::prepare_output`]).
    pub picture: Option<&'a wgpu::TextureView>,
    /// One view of the format [`VISIBILITY_FORMAT`](crate::render::nodes::pipelines::VISIBILITY_FORMAT) for
    /// each light of the scene ([`FrameLights::of_scene`](crate::sets::FrameLights::of_scene)), as large as the
    /// targets of the frame, or an empty slice for no pictures of visibility.
    pub visibility: &'a [wgpu::TextureView],
}

impl Renderer {
    /// Makes the pipeline that writes pictures whose view has this format. Call it once, and again after
    /// [`RenderSettings::exposure`] changed. If the view of a picture is sRGB and its texture is not, prepare the format of the
    /// view alone, because a view does not tell its format. If it fails, the next frame draws nothing and has the error
    /// ([`Renderer::failure`]).
    ///
    /// [`RenderSettings::exposure`]: crate::render::RenderSettings::exposure
    pub fn prepare_output(&mut self, format: wgpu::TextureFormat) {
        let exposure = self.settings.sanitized().exposure;
        if let Err(error) = self.tonemap.prepare(&self.gpu, format, exposure) {
            self.fail(error);
        }
    }

    /// Returns the format of a picture that was asked for but not written, because [`Renderer::prepare_output`] was not called
    /// with it. It is forgotten when it is prepared, or when a picture is written.
    pub fn unprepared_output(&self) -> Option<wgpu::TextureFormat> {
        self.tonemap.unprepared()
    }

    /// Records the prepared frame. Without a view, a size or a device it records nothing.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, outputs: &FrameOutputs) {
        let Some(mut frame) = self.begin_record(encoder) else {
            return;
        };
        // Before all passes on the screen: however often a light is looked up, its pictures are drawn once.
        self.draw_pictures(frame.encoder);
        // First on the screen: every later pass tests against its depth.
        nodes::ambient::record(&mut frame, self.background(), self.batches(&self.frame.ambient));
        // Before the lights: techniques read depth and planes while they write the stencil.
        self.record_receivers(&mut frame, LightSurfaces::Opaque);
        // Light by light: the lights take turns with one stencil and one mask.
        self.record_lights(&mut frame, outputs);
        // After the lights: surfaces that a light does not see show only in pictures of its visibility.
        self.record_dark(&mut frame, outputs);
        // Before blended surfaces: shadowed lights skip the front layer there.
        let front = self.record_front_layer(&mut frame);
        // After all opaque surfaces: blended surfaces lie in front of everything that writes depth.
        self.record_blended(&mut frame, front);
        // After blended surfaces: nothing covers the front layer later.
        self.record_front_lights(&mut frame, front, outputs);
        // Over the picture, with the same exposure.
        self.record_debug(&mut frame);
        // Last: the tonemap reads the radiance of all other passes.
        self.record_picture(&mut frame, outputs);
        self.timings.end_frame(frame.encoder);
    }

    fn begin_record<'a>(&'a self, encoder: &'a mut wgpu::CommandEncoder) -> Option<Recording<'a>> {
        let (targets, (radiance, _)) = (self.targets.as_ref()?, self.radiance.as_ref()?);
        self.begin_recording(encoder, &radiance.view, targets)
    }

    /// Begins to record a frame over a radiance. Returns `None` without a device.
    pub(in crate::render) fn begin_recording<'a>(
        &'a self,
        encoder: &'a mut wgpu::CommandEncoder,
        radiance: &'a wgpu::TextureView,
        targets: &'a FrameTargets,
    ) -> Option<Recording<'a>> {
        if self.gpu.context.is_lost() {
            return None;
        }
        self.timings.begin_frame();
        let canvas = Canvas {
            radiance,
            targets,
            viewport: self.frame.viewport,
        };
        Some(Recording {
            encoder,
            canvas,
            view: &self.view_group,
            surfaces: self.surface_resources(),
            timings: &self.timings,
        })
    }

    /// Returns the frame's batches of a range.
    pub(in crate::render) fn batches(&self, range: &Range<usize>) -> &[Batch] {
        &self.frame.batches[range.clone()]
    }

    fn background(&self) -> wgpu::Color {
        let [r, g, b] = self.settings.sanitized().background.as_dvec3().to_array();
        wgpu::Color { r, g, b, a: 1.0 }
    }

    /// Lets the techniques draw their light-space pictures.
    pub(in crate::render) fn draw_pictures(&self, encoder: &mut wgpu::CommandEncoder) {
        let input = PictureInput {
            context: &self.gpu.context,
            meshes: &self.meshes,
            materials: &self.materials,
            timings: &self.timings,
            labels: self.labels.all(),
        };
        for technique in self.techniques.iter() {
            technique.draw_pictures(encoder, &input);
        }
    }

    /// Draws the depth of the front layer of blended surfaces. Returns `None` if no shadowed light reaches a
    /// blended surface.
    fn record_front_layer(&self, frame: &mut Recording) -> Option<&FrameTargets> {
        let front = self.front.as_ref().filter(|_| self.frame.has_front_layer())?;
        nodes::front_layer::record(frame, front, self.batches(&self.frame.blended_batches));
        Some(front)
    }

    fn record_blended(&self, frame: &mut Recording, front: Option<&FrameTargets>) {
        if !self.frame.blended.is_empty() {
            let front = front.map(|front| &front.depth_group);
            nodes::blended::record(frame, &self.light_group, &self.frame, front);
        }
    }

    fn record_debug(&self, frame: &mut Recording) {
        if !self.settings.debug_volumes {
            return;
        }
        let mut pass = frame.canvas.begin_light_pass(frame.encoder, "debug", None);
        for light in &self.frame.lights {
            let [x, y, width, height] = light.scissor;
            pass.set_scissor_rect(x, y, width, height);
            for light in [light].into_iter().chain(self.frame.companions_of(light)) {
                if let Some(shadow) = light.shadow {
                    let input = LightSurfaces::Opaque.record_input(self, light);
                    self.techniques[shadow.technique.0].debug(light.light, &mut pass, &input);
                }
            }
        }
    }

    fn record_picture(&self, frame: &mut Recording, outputs: &FrameOutputs) {
        if let (Some(picture), Some((_, group))) = (outputs.picture, &self.radiance) {
            self.tonemap.record(frame.encoder, picture, group, frame.timings);
        }
    }
}
