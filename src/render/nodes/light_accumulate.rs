//! Adds one light to the surfaces of its set I.
//!
//! Shader  `shaders/passes/light_accumulate.wgsl`
//! Groups  0 view, 1 light, 2 material, 3 mask
//! Reads   depth (equal), and the stencil (in bounds and count 0) or the mask.  Writes  radiance, added
//! Order   after the technique marked or resolved the same light

use super::surface_pass::SurfacePass;
use super::surfaces::{SurfaceResources, draw_batches};
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::frame::draw_list::Batch;
use crate::render::frame::frame_data::LightSlot;
use crate::render::gpu::strided::Strided;
use crate::render::pools::gpu_types::Light;

/// Records the draws into the light's pass.
pub fn record(
    pass: &mut wgpu::RenderPass,
    view: &wgpu::BindGroup,
    (lights, slot): (&wgpu::BindGroup, LightSlot),
    kind: SurfacePass,
    mask: Option<&wgpu::BindGroup>,
    batches: &[Batch],
    resources: &SurfaceResources,
) {
    pass.set_stencil_reference(STENCIL_IN_BOUNDS);
    pass.set_bind_group(0, view, &[]);
    pass.set_bind_group(1, lights, &[Strided::<Light>::offset(slot.0)]);
    if let Some(mask) = mask {
        pass.set_bind_group(3, mask, &[]);
    }
    draw_batches(pass, kind, batches, resources);
}
