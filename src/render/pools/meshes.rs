//! Meshes on the GPU. There is one for each mesh that objects of any view share, and one for each posed
//! object of a view.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use bevy_ecs::prelude::*;
use glam::{Vec2, Vec3, Vec4};
use wgpu::util::DeviceExt;

use super::gpu_types::SurfaceVertex;
use crate::render::gpu::bind_groups::bind_in_order;
use crate::render::gpu::slots::Slots;
use crate::render::{Gpu, RenderContext};
use crate::scene::{MeshData, PosedMesh, Submesh};

/// A mesh in GPU buffers.
#[derive(Debug)]
pub struct GpuMesh {
    /// The positions, 12 bytes a vertex. Shadow volumes draw their caps and sides from the same buffer.
    pub positions: wgpu::Buffer,
    /// The bind group of the positions as a storage buffer, of the layout [`BindGroupLayouts::positions`].
    pub positions_group: wgpu::BindGroup,
    /// The attributes beside the position, one [`SurfaceVertex`] a vertex.
    pub surface: wgpu::Buffer,
    /// The indices, one `u32` each.
    pub indices: wgpu::Buffer,
    /// The submeshes, one for each material. Their ranges are cut to the indices that exist.
    pub submeshes: Vec<Submesh>,
    /// The middle of each submesh's bounds, local. It is empty for a posed mesh.
    pub middles: Vec<Vec3>,
    source: Arc<MeshData>,
    /// Counts the bytes of the mesh until the mesh is dropped.
    _counted: Counted,
}

/// A number of bytes that is part of a total while this value exists.
#[derive(Debug)]
struct Counted {
    bytes: u64,
    total: Arc<AtomicU64>,
}

impl Counted {
    fn new(bytes: u64, total: &Arc<AtomicU64>) -> Self {
        total.fetch_add(bytes, Ordering::Relaxed);
        Self {
            bytes,
            total: total.clone(),
        }
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        self.total.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

/// The meshes without a pose that any view holds. The key is the address of the mesh's data, which the mesh
/// keeps alive.
#[derive(Debug, Default)]
pub struct SharedMeshes {
    known: Mutex<HashMap<usize, Weak<GpuMesh>>>,
    bytes: Arc<AtomicU64>,
}

impl SharedMeshes {
    fn known(&self) -> MutexGuard<'_, HashMap<usize, Weak<GpuMesh>>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The number of bytes that all meshes and their poses take on the device.
    pub fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }

    fn get(&self, mesh: &Arc<MeshData>) -> Option<Arc<GpuMesh>> {
        self.known().get(&(Arc::as_ptr(mesh) as usize))?.upgrade()
    }

    fn insert(&self, mesh: &Arc<GpuMesh>) {
        let address = Arc::as_ptr(&mesh.source) as usize;
        self.known().insert(address, Arc::downgrade(mesh));
    }

    /// Removes the addresses of meshes that no view holds.
    fn forget_unused(&self) {
        self.known().retain(|_, mesh| mesh.strong_count() > 0);
    }
}

/// The object or objects that a GPU mesh belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Key {
    /// The mesh of all unposed objects that share it, by the address of the `Arc`'s content. The entry keeps
    /// that content alive.
    Shared(usize),
    /// The mesh of one posed object.
    Posed(Entity),
}

/// An object that is not drawn because the device allows no buffer of its mesh's size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OversizedMesh {
    /// The entity of the object.
    pub entity: Entity,
    /// Size of the buffer that the mesh needs, bytes.
    pub needed: u64,
    /// Size of the largest buffer of this use that the device allows, bytes.
    pub limit: u64,
}

/// The meshes that one view uses, by index.
#[derive(Debug, Default)]
pub struct MeshPool {
    slots: Slots<Key, Arc<GpuMesh>>,
    scratch: Vec<SurfaceVertex>,
    /// The objects that are not drawn because the device allows no buffer of their mesh's size. They are in
    /// the order of the objects.
    pub oversized: Vec<OversizedMesh>,
}

impl MeshPool {
    /// The mesh at `index`, if it is in use.
    pub fn get(&self, index: u32) -> Option<&GpuMesh> {
        self.slots.get(index).map(Arc::as_ref)
    }

    /// Begins a new count of the meshes in use.
    pub fn begin(&mut self) {
        self.slots.begin();
        self.oversized.clear();
    }

    /// Frees the meshes that were not requested since [`MeshPool::begin`].
    pub fn end(&mut self, gpu: &Gpu) {
        self.slots.end();
        gpu.meshes.forget_unused();
    }

    /// Frees the meshes that are not among `indices`.
    pub fn keep(&mut self, gpu: &Gpu, indices: impl Iterator<Item = u32>) {
        self.slots.keep(indices);
        gpu.meshes.forget_unused();
    }

    /// Returns the index of an object's mesh. The mesh is uploaded if it is new. Returns `None` for a mesh
    /// without triangles, and for a mesh that the device cannot hold.
    pub fn acquire(
        &mut self,
        gpu: &Gpu,
        entity: Entity,
        mesh: &Arc<MeshData>,
        posed: Option<&PosedMesh>,
    ) -> Option<u32> {
        if mesh.indices.is_empty() || !mesh.positions.iter().any(|position| position.is_finite()) {
            return None;
        }
        let key = match posed {
            Some(_) => Key::Posed(entity),
            None => Key::Shared(Arc::as_ptr(mesh) as usize),
        };
        if let Some(index) = self.slots.acquire(key, |entry| Arc::ptr_eq(&entry.source, mesh)) {
            return Some(index);
        }
        let is_shared = posed.is_none();
        if is_shared && let Some(known) = gpu.meshes.get(mesh) {
            return Some(self.slots.insert(key, known));
        }
        let largest = (mesh.positions.len() * size_of::<SurfaceVertex>()).max(mesh.indices.len() * 4) as u64;
        let limits = gpu.context.device.limits();
        let positions = (mesh.positions.len() * 12) as u64;
        let buffers = [
            (largest, limits.max_buffer_size),
            (positions, limits.max_storage_buffer_binding_size),
        ];
        if let Some(&(needed, limit)) = buffers.iter().find(|(needed, limit)| needed > limit) {
            self.oversized.push(OversizedMesh {
                entity,
                needed,
                limit,
            });
            return None;
        }
        let entry = Arc::new(self.upload(gpu, mesh, posed));
        if is_shared {
            gpu.meshes.insert(&entry);
        }
        Some(self.slots.insert(key, entry))
    }

    fn upload(&mut self, gpu: &Gpu, mesh: &Arc<MeshData>, posed: Option<&PosedMesh>) -> GpuMesh {
        let device = &gpu.context.device;
        let buffer = |label: &str, contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(&format!("{} {label}", mesh.name)),
                contents,
                usage: usage | wgpu::BufferUsages::COPY_DST,
            })
        };
        let positions = buffer(
            "positions",
            bytemuck::cast_slice(posed_positions(mesh, posed)),
            wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::STORAGE,
        );
        fill_surface(&mut self.scratch, mesh, posed);
        let surface = buffer(
            "surface",
            bytemuck::cast_slice(&self.scratch),
            wgpu::BufferUsages::VERTEX,
        );
        let drawable = drawable_indices(mesh);
        let indices = buffer(
            "indices",
            bytemuck::cast_slice(&drawable),
            wgpu::BufferUsages::INDEX,
        );
        let middle = |part| middle(&mesh.positions, &drawable[mesh.submesh_range(part)]);
        let middles = match posed {
            Some(_) => Vec::new(),
            None => mesh.submeshes.iter().map(middle).collect(),
        };
        let bytes = positions.size() + surface.size() + indices.size();
        GpuMesh {
            _counted: Counted::new(bytes, &gpu.meshes.bytes),
            positions_group: bind_in_order(
                device,
                "positions",
                &gpu.layouts.positions,
                [positions.as_entire_binding()],
            ),
            positions,
            surface,
            indices,
            submeshes: mesh
                .submeshes
                .iter()
                .map(|part| {
                    let range = mesh.submesh_range(part);
                    Submesh {
                        first_index: range.start as u32,
                        index_count: range.len() as u32,
                    }
                })
                .collect(),
            middles,
            source: mesh.clone(),
        }
    }

    /// Uploads this frame's pose of one object.
    pub fn write_pose(&mut self, context: &RenderContext, index: u32, posed: &PosedMesh) {
        let Some(mesh) = self.slots.get(index) else {
            return;
        };
        let positions = posed_positions(&mesh.source, Some(posed));
        fill_surface(&mut self.scratch, &mesh.source, Some(posed));
        context
            .queue
            .write_buffer(&mesh.positions, 0, bytemuck::cast_slice(positions));
        context
            .queue
            .write_buffer(&mesh.surface, 0, bytemuck::cast_slice(&self.scratch));
    }
}

/// Returns the posed positions once they have been computed, and the mesh's own positions before.
fn posed_positions<'a>(mesh: &'a MeshData, posed: Option<&'a PosedMesh>) -> &'a [Vec3] {
    match posed {
        Some(posed) if posed.is_whole(mesh.positions.len()) => &posed.positions,
        _ => &mesh.positions,
    }
}

/// Returns the middle of the bounds of the vertices that are named.
fn middle(positions: &[Vec3], indices: &[u32]) -> Vec3 {
    let corners = || indices.iter().map(|index| positions[*index as usize]);
    let least = corners().reduce(Vec3::min).unwrap_or(Vec3::ZERO);
    let most = corners().reduce(Vec3::max).unwrap_or(Vec3::ZERO);
    0.5 * least + 0.5 * most
}

/// Returns the mesh's indices. Triangles with a vertex that is missing or not finite are collapsed to a
/// point, because a GPU's result for them is not defined.
fn drawable_indices(mesh: &MeshData) -> Cow<'_, [u32]> {
    let is_finite = |index: &u32| mesh.positions.get(*index as usize).is_some_and(|p| p.is_finite());
    if mesh.indices.iter().all(is_finite) {
        return Cow::Borrowed(&mesh.indices);
    }
    let somewhere = mesh.positions.iter().position(|p| p.is_finite()).unwrap_or(0) as u32;
    let mut indices = mesh.indices.clone();
    for corners in indices.chunks_mut(3) {
        if !corners.iter().all(is_finite) {
            corners.fill(somewhere);
        }
    }
    Cow::Owned(indices)
}

/// Interleaves the attributes of each vertex beside its position. An attribute that is missing or not finite
/// takes a neutral value. A normal then points up.
fn fill_surface(out: &mut Vec<SurfaceVertex>, mesh: &MeshData, posed: Option<&PosedMesh>) {
    let posed = posed.filter(|posed| posed.is_whole(mesh.positions.len()));
    let normals = posed.map_or(&mesh.normals, |posed| &posed.normals);
    let tangents = posed.map_or(&mesh.tangents, |posed| &posed.tangents);
    out.clear();
    out.extend((0..mesh.positions.len()).map(|i| {
        let uv = |set: &[Vec2]| {
            set.get(i)
                .copied()
                .filter(|uv| uv.is_finite())
                .unwrap_or(Vec2::ZERO)
        };
        let (uv0, uv1) = (uv(&mesh.uv0), uv(&mesh.uv1));
        let normal = normals
            .get(i)
            .copied()
            .filter(|n| n.is_finite() && *n != Vec3::ZERO);
        let tangent = tangents.get(i).copied();
        let tangent = tangent.filter(|t| t.is_finite() && t.truncate() != Vec3::ZERO);
        let color = mesh.colors.get(i).copied().filter(|color| color.is_finite());
        SurfaceVertex {
            normal: normal.unwrap_or(Vec3::Y).to_array(),
            tangent: tangent.unwrap_or(Vec4::ZERO).to_array(),
            uv: [uv0.x, uv0.y, uv1.x, uv1.y],
            color: color.unwrap_or(Vec4::ONE).to_array(),
        }
    }));
}
