//! The pipelines of surface passes that a frame needs.

use std::ops::Range;

use super::front_lights::LightSurfaces;
use crate::render::RenderError;
use crate::render::nodes::surface_pass::SurfacePass;
use crate::render::renderer::Renderer;

impl Renderer {
    /// Takes the pipelines of all surface passes that the prepared frame will draw. Returns the first error.
    pub(in crate::render) fn require_pipelines(&mut self) -> Result<(), RenderError> {
        let measures = self.settings.pixel_measures;
        let reads_planes = self.reads_planes();
        let Self {
            frame,
            pipelines,
            gpu,
            host,
            ..
        } = self;
        let mut required = Ok(());
        let mut require = |pass, batches: Range<usize>| {
            for batch in &frame.batches[batches] {
                let made = pipelines.require(gpu, pass, batch.variant);
                required = std::mem::replace(&mut required, Ok(())).and(made);
            }
        };
        let drawn = match host {
            Some(_) => SurfacePass::HostSurface,
            None => SurfacePass::Ambient,
        };
        require(drawn, frame.ambient.clone());
        if reads_planes || measures {
            require(SurfacePass::ReceiverPlane, frame.ambient.clone());
            require(SurfacePass::ReceiverPlane, frame.blended_batches.clone());
        }
        for light in &frame.lights {
            let visibility = light.kind();
            if measures {
                require(SurfacePass::LightCount, light.batches.clone());
            }
            require(LightSurfaces::Opaque.pass(light), light.batches.clone());
            if light.is_scaled || light.is_tinted {
                require(SurfacePass::WholeMask, light.batches.clone());
                require(SurfacePass::WholeMask, light.front.clone());
            }
            if let Some(visibility) = visibility {
                require(SurfacePass::visibility(visibility), light.batches.clone());
            }
        }
        for companion in &frame.companions {
            for batches in [&companion.shadow.batches, &companion.shadow.front] {
                require(SurfacePass::WholeMask, batches.clone());
                require(SurfacePass::DarkerMask, batches.clone());
            }
        }
        for (_, batches) in &frame.dark {
            require(SurfacePass::Dark, batches.clone());
        }
        for light in &frame.lights {
            if let Some(visibility) = light.kind() {
                require(LightSurfaces::Front.pass(light), light.front.clone());
                require(SurfacePass::visibility(visibility), light.front.clone());
                require(SurfacePass::VisibilityFront, light.front.clone());
            }
        }
        let blended = [SurfacePass::AmbientBlended, SurfacePass::LightBlended];
        let front = [SurfacePass::LightBehindFront, SurfacePass::FrontDepth];
        for pass in blended
            .into_iter()
            .chain(front.into_iter().filter(|_| frame.has_front_layer()))
        {
            require(pass, frame.blended_batches.clone());
        }
        required
    }
}
