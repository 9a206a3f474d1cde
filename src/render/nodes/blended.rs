//! Blended surfaces, back to front: each object over what is behind it, then its lights added, unshadowed. Shadowed
//! lights leave out the front layer, which gets them with their shadows afterwards: at its pixels nothing comes later.
//!
//! Shaders `shaders/passes/ambient.wgsl`, `shaders/passes/light_accumulate.wgsl` with `BLENDED`
//! Groups  0 view, 1 light, 2 material, 3 front depth
//! Reads   depth.  Writes  radiance
//! Order   after all lights and the depth of the front layer, before the lights of the front layer
//!
//! As colour and coverage of one object are written before the next, any number of lights needs no second buffer.

use super::surface_pass::SurfacePass;
use super::surfaces::draw_batches;
use crate::render::frame::frame_data::{FrameData, LightSlot};
use crate::render::frame::recording::Recording;
use crate::render::gpu::strided::Strided;
use crate::render::pools::gpu_types::Light;

/// One blended object: its batches, and the light slots that reach it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BlendedDraw {
    /// Index into the frame's blended batches.
    pub batch: usize,
    /// Range of the frame's list of blended lights.
    pub lights: std::ops::Range<usize>,
}

/// A light that reaches a blended object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlendedLight {
    /// Where the constants of the light are.
    pub slot: LightSlot,
    /// Whether the front layer is left out.
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
    // Here ambient and light pipelines take turns. They share one layout, of which the ambient ones leave group 1 unread:
    // with a layout that lacks it, wgpu 29 on lavapipe 22.3 reads the last light as the next object's material.
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
