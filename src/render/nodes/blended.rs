//! Blended surfaces, back to front: each object over what is behind it, then its lights added, unshadowed.
//!
//! Shaders `shaders/passes/ambient.wgsl`, `shaders/passes/light_accumulate.wgsl` with `BLENDED`
//! Groups  0 view, 1 light, 2 material
//! Reads   depth.  Writes  radiance
//! Order   after all lights
//!
//! A blended surface has no place in the depth buffer, so no per-light visibility can be looked up for it; and
//! as colour and coverage of one object are written before the next, any number of lights needs no second buffer.

use super::surfaces::{SurfaceResources, draw_batches};
use crate::render::bind_groups::LIGHT_STRIDE;
use crate::render::draw_list::Batch;
use crate::render::pipelines::SurfacePass;

/// One blended object: its batches, and the light slots that reach it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BlendedDraw {
    /// Index into the frame's blended batches.
    pub batch: usize,
    /// Range of the frame's list of light slots.
    pub lights: std::ops::Range<usize>,
}

/// Records the draws.
pub fn record(
    pass: &mut wgpu::RenderPass,
    view: &wgpu::BindGroup,
    lights: &wgpu::BindGroup,
    draws: &[BlendedDraw],
    batches: &[Batch],
    light_slots: &[u32],
    resources: &SurfaceResources,
) {
    pass.set_bind_group(0, view, &[]);
    // Here ambient and light pipelines take turns. They share one layout, of which the ambient ones leave group 1 unread:
    // with a layout that lacks it, wgpu 29 on lavapipe 22.3 reads the last light as the next object's material.
    pass.set_bind_group(1, lights, &[0]);
    for draw in draws {
        let batch = &batches[draw.batch..=draw.batch];
        draw_batches(pass, SurfacePass::AmbientBlended, batch, resources);
        for &slot in &light_slots[draw.lights.clone()] {
            pass.set_bind_group(1, lights, &[slot * LIGHT_STRIDE as u32]);
            draw_batches(pass, SurfacePass::LightBlended, batch, resources);
        }
    }
}
