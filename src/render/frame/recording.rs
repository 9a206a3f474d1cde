//! What the passes of a frame record with.

use super::canvas::Canvas;
use super::targets::FrameTargets;
use crate::render::gpu::timings::Timings;
use crate::render::nodes::surfaces::SurfaceResources;

/// What every pass of a frame records with.
#[derive(Debug)]
pub struct Recording<'a> {
    /// The encoder of the frame.
    pub encoder: &'a mut wgpu::CommandEncoder,
    /// What passes draw into.
    pub canvas: Canvas<'a>,
    /// Group 0: the view and its objects.
    pub view: &'a wgpu::BindGroup,
    /// What the batches of surfaces refer to.
    pub surfaces: SurfaceResources<'a>,
    /// The timers of passes.
    pub timings: &'a Timings,
}

impl<'a> Recording<'a> {
    /// The same with another depth and stencil.
    pub fn on<'b>(&'b mut self, targets: &'b FrameTargets) -> Recording<'b>
    where
        'a: 'b,
    {
        Recording {
            encoder: self.encoder,
            canvas: Canvas {
                targets,
                ..self.canvas
            },
            view: self.view,
            surfaces: self.surfaces,
            timings: self.timings,
        }
    }

    /// Begins the pass of one light or of several, which keeps the radiance that is there.
    pub fn begin_light_pass(&mut self, label: &str) -> wgpu::RenderPass<'_> {
        let timer = self.timings.pass(label);
        self.canvas.begin_light_pass(self.encoder, label, timer)
    }
}
