//! Adds one light to the surfaces of its set I.
//!
//! Shader  `shaders/passes/light_accumulate.wgsl`
//! Groups  0 view, 1 light, 2 material, 3 mask
//! Reads   depth (equal), the stencil (in bounds, and count 0 if the technique counts) and the mask.
//! Writes  radiance, added; the stencil: 0 where a surface was lit, so that of surfaces in one place only the first adds
//! Order   after the light began, and after the technique marked or resolved it

use super::surface_pass::SurfacePass;
use super::surfaces::{SurfaceResources, draw_batches};
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::frame::draw_list::Batch;
use crate::render::frame::frame_data::LightSlot;
use crate::render::gpu::strided::Strided;
use crate::render::pools::gpu_types::Light;

/// Records the draws of one light into the light's pass.
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
