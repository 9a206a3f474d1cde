//! Draws blended surfaces, back to front. Each object is drawn over what is behind it, and its lights are
//! then added without shadows. Shadowed lights leave out the front layer here. They are added to it
//! afterwards with their shadows, because nothing covers its pixels later.
//!
//! Shaders `shaders/passes/ambient.wgsl`, `shaders/passes/light_accumulate.wgsl` with `BLENDED`
//! Groups  0 view, 1 light, 2 material, 3 front depth
//! Reads   depth.  Writes  radiance
//! Order   after all lights and the depth of the front layer, before the lights of the front layer
//!
//! Colour and coverage of one object are written before the next object is drawn. So no second buffer is
//! needed for any number of lights.

use super::surface_pass::SurfacePass;
use super::surfaces::draw_batches;
use crate::render::frame::frame_data::{FrameData, LightSlot};
use crate::render::frame::recording::Recording;
use crate::render::gpu::strided::Strided;
use crate::render::pools::gpu_types::Light;

/// One blended submesh of an object: its batch, and the lights that reach it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BlendedDraw {
    /// Index into the frame's batches.
    pub batch: usize,
    /// Range of the frame's list of blended lights.
    pub lights: std::ops::Range<usize>,
}

/// A light that reaches a blended object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlendedLight {
    /// The slot of the light's constants.
    pub slot: LightSlot,
    /// True if the light leaves out the front layer, because the light has a mask or a stencil.
    pub behind_front: bool,
}

/// Records the draws. `front` is the depth of the front layer, if there is one.
pub fn record(
    frame: &mut Recording,
    lights: &wgpu::BindGroup,
    data: &FrameData,
    front: Option<&wgpu::BindGroup>,
) {
    let (view, surfaces) = (frame.view, frame.surfaces);
    let mut pass = frame.begin_light_pass("blended");
    let pass = &mut pass;
    pass.set_bind_group(0, view, &[]);
    // Pipelines of ambient light and of lights take turns here. They share one layout, and those of ambient
    // light leave group 1 unread. With a layout that lacks group 1, wgpu 29 on lavapipe 22.3 reads the last
    // light as the next object's material.
    pass.set_bind_group(1, lights, &[0]);
    if let Some(front) = front {
        pass.set_bind_group(3, front, &[]);
    }
    for draw in &data.blended {
        let batch = &data.batches[draw.batch..=draw.batch];
        draw_batches(pass, SurfacePass::AmbientBlended, batch, &surfaces);
        for light in &data.blended_lights[draw.lights.clone()] {
            pass.set_bind_group(1, lights, &[Strided::<Light>::offset(light.slot.0)]);
            let kind = if light.behind_front {
                SurfacePass::LightBehindFront
            } else {
                SurfacePass::LightBlended
            };
            draw_batches(pass, kind, batch, &surfaces);
        }
    }
}
