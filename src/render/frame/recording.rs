//! The encoder, targets and timers with which the passes of a frame record.

use super::canvas::Canvas;
use super::targets::FrameTargets;
use crate::render::gpu::timings::Timings;
use crate::render::nodes::surfaces::SurfaceResources;

/// Everything with which a pass of a frame records.
#[derive(Debug)]
pub struct Recording<'a> {
    /// The encoder of the frame.
    pub encoder: &'a mut wgpu::CommandEncoder,
    /// The targets that passes draw into.
    pub canvas: Canvas<'a>,
    /// The bind group 0: the view and its objects.
    pub view: &'a wgpu::BindGroup,
    /// The meshes, materials and instances that the batches refer to by index.
    pub surfaces: SurfaceResources<'a>,
    /// The timers of passes.
    pub timings: &'a Timings,
}

impl<'a> Recording<'a> {
    /// Returns this recording with other targets of depth and stencil.
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

    /// Begins the pass of one light or of several. It keeps the radiance that is there.
    pub fn begin_light_pass(&mut self, label: &str) -> wgpu::RenderPass<'_> {
        let timer = self.timings.pass(label);
        self.canvas.begin_light_pass(self.encoder, label, timer)
    }
}
