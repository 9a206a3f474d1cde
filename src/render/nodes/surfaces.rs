//! Draws batches of surfaces with the pipelines of one pass.

use super::pipelines::SurfacePipelines;
use super::surface_pass::SurfacePass;
use crate::render::frame::draw_list::Batch;
use crate::render::pools::materials::MaterialPool;
use crate::render::pools::meshes::{GpuMesh, MeshPool};

/// What a batch's indices refer to.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceResources<'a> {
    /// Pipelines.
    pub pipelines: &'a SurfacePipelines,
    /// Meshes.
    pub meshes: &'a MeshPool,
    /// Materials.
    pub materials: &'a MaterialPool,
    /// Object index by instance.
    pub instances: &'a wgpu::Buffer,
}

/// Records one draw a batch; state is set only where it changes.
pub fn draw_batches(
    pass: &mut wgpu::RenderPass,
    kind: SurfacePass,
    batches: &[Batch],
    resources: &SurfaceResources,
) {
    let mut last: Option<&Batch> = None;
    for batch in batches {
        let changed = |differs: fn(&Batch, &Batch) -> bool| last.is_none_or(|last| differs(last, batch));
        let (Some(mesh), Some(material)) = (
            resources.meshes.get(batch.mesh),
            resources.materials.get(batch.material),
        ) else {
            continue;
        };
        if changed(|a, b| a.variant != b.variant) {
            let Some(pipeline) = resources.pipelines.get(kind, batch.variant) else {
                continue;
            };
            pass.set_pipeline(pipeline);
        }
        if changed(|a, b| a.material != b.material) {
            pass.set_bind_group(2, &material.bind_group, &[]);
        }
        if changed(|a, b| a.mesh != b.mesh) {
            set_mesh(pass, mesh, resources.instances);
        }
        draw_batch(pass, mesh, batch);
        last = Some(batch);
    }
}

/// Sets the buffers of [`SURFACE_BUFFERS`](crate::render::nodes::pipelines::SURFACE_BUFFERS), and the indices.
pub fn set_mesh(pass: &mut wgpu::RenderPass, mesh: &GpuMesh, instances: &wgpu::Buffer) {
    pass.set_vertex_buffer(0, mesh.positions.slice(..));
    pass.set_vertex_buffer(1, mesh.surface.slice(..));
    pass.set_vertex_buffer(2, instances.slice(..));
    pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
}

/// Records the draw of a batch of a mesh that is set.
pub fn draw_batch(pass: &mut wgpu::RenderPass, mesh: &GpuMesh, batch: &Batch) {
    let submesh = mesh.submeshes[batch.submesh as usize];
    let indices = submesh.first_index..submesh.first_index + submesh.index_count;
    pass.draw_indexed(indices, 0, batch.instances.clone());
}
