//! Layouts and indices of volumes, which all views of a device share.

use super::gpu_types::Caster;
use super::quads::QuadIndices;
use crate::render::gpu::bind_groups::{STORAGE, bind_in_order, buffer_entry};
use crate::render::{Gpu, RenderContext};

/// The parts of the recorder that all views of a device share.
#[derive(Debug)]
pub(super) struct LongLived {
    /// The layout of group 2: casters and silhouette edges.
    pub(super) casters: wgpu::BindGroupLayout,
    pub(super) quads: QuadIndices,
}

impl LongLived {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let vertex = wgpu::ShaderStages::VERTEX;
        let entries = [
            buffer_entry(0, vertex, STORAGE, false, size_of::<Caster>()),
            buffer_entry(1, vertex, STORAGE, false, 8),
        ];
        let descriptor = wgpu::BindGroupLayoutDescriptor {
            label: Some("volume casters"),
            entries: &entries,
        };
        Self {
            casters: gpu.context.device.create_bind_group_layout(&descriptor),
            quads: QuadIndices::new(&gpu.context),
        }
    }
}

/// Makes the bind group of group 2.
pub(super) fn bind(
    context: &RenderContext,
    layout: &wgpu::BindGroupLayout,
    casters: &wgpu::Buffer,
    edges: &wgpu::Buffer,
) -> wgpu::BindGroup {
    bind_in_order(
        &context.device,
        "volume casters",
        layout,
        [casters.as_entire_binding(), edges.as_entire_binding()],
    )
}
