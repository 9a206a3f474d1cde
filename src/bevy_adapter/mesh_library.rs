//! The game's meshes, converted for shadows, by asset.

use std::sync::Arc;

use bevy::asset::{AssetEvent, AssetId, Assets};
use bevy::ecs::prelude::*;
use bevy::mesh::Mesh;
use bevy::platform::collections::HashMap;
use bevy::tasks::{AsyncComputeTaskPool, Task, block_on, poll_once};

use super::mesh_convert::{MeshRefusal, convert_mesh};
use super::settings::AntumbraSettings;
use crate::geometry::edge_mesh::EdgeMeshError;
use crate::scene::MeshData;
use crate::silhouettes::CasterMesh;

/// A mesh that is ready to cast shadows.
#[derive(Clone, Debug)]
pub struct ReadyMesh {
    /// Vertices and triangles of the mesh.
    pub data: Arc<MeshData>,
    /// Edges of the mesh, from which silhouettes are found. With an error the mesh is lit but casts no
    /// shadow.
    pub edges: Result<Arc<CasterMesh>, EdgeMeshError>,
}

/// The state of a mesh in the library.
#[derive(Debug)]
pub enum MeshEntry {
    /// The mesh is being made ready on another thread.
    Building(Task<ReadyMesh>),
    /// The mesh is ready.
    Ready(ReadyMesh),
    /// The mesh cannot cast shadows.
    Refused(MeshRefusal),
}

/// The game's meshes, by asset. They are updated in `PostUpdate`, in
/// [`CollectMeshes`](super::AntumbraMainSystems::CollectMeshes).
#[derive(Resource, Debug, Default)]
pub struct MeshLibrary {
    entries: HashMap<AssetId<Mesh>, MeshEntry>,
    /// Meshes that are being made ready on other threads.
    building: Vec<AssetId<Mesh>>,
    /// Meshes whose entry changed in this frame, in the order of the changes.
    changed: Vec<AssetId<Mesh>>,
}

impl MeshLibrary {
    /// Returns the state of a mesh; `None` while its asset is not loaded.
    pub fn get(&self, id: AssetId<Mesh>) -> Option<&MeshEntry> {
        self.entries.get(&id)
    }

    /// Returns the meshes whose entry changed in this frame.
    pub fn changed(&self) -> &[AssetId<Mesh>] {
        &self.changed
    }

    /// Returns the number of meshes that are being made ready on other threads.
    pub fn building(&self) -> usize {
        self.building.len()
    }

    fn poll(&mut self) {
        let (entries, changed) = (&mut self.entries, &mut self.changed);
        self.building.retain(|&id| {
            let Some(entry) = entries.get_mut(&id) else {
                return false;
            };
            let MeshEntry::Building(task) = entry else {
                return false; // a newer version of the mesh is ready or refused
            };
            let Some(ready) = block_on(poll_once(task)) else {
                return true;
            };
            *entry = MeshEntry::Ready(ready);
            changed.push(id);
            false
        });
    }

    fn convert(&mut self, id: AssetId<Mesh>, mesh: &Mesh, immediate_triangles: usize) {
        let entry = match convert_mesh(mesh, &format!("mesh {id}")) {
            // The mesh changed, but its new data cannot be read. The known shape is the best guess, so it
            // stays.
            Err(MeshRefusal::RenderWorldOnly)
                if matches!(self.entries.get(&id), Some(MeshEntry::Ready(_))) =>
            {
                return;
            }
            Err(refusal) => MeshEntry::Refused(refusal),
            Ok(data) if data.triangle_count() <= immediate_triangles => MeshEntry::Ready(build(data)),
            Ok(data) => MeshEntry::Building(AsyncComputeTaskPool::get().spawn(async move { build(data) })),
        };
        if matches!(entry, MeshEntry::Building(_)) && !self.building.contains(&id) {
            self.building.push(id);
        }
        // A mesh under construction also counts as changed, so that its old shape casts no shadow.
        self.changed.push(id);
        self.entries.insert(id, entry);
    }
}

fn build(data: MeshData) -> ReadyMesh {
    let edges = CasterMesh::build(&data).map(Arc::new);
    ReadyMesh {
        data: Arc::new(data),
        edges,
    }
}

/// Makes added and changed meshes ready, and forgets meshes that are gone.
///
/// Runs in `PostUpdate`, after asset events and before extraction. This is the last moment at which meshes
/// that only the render world keeps can be read. The system copies the vertices. Other threads build the
/// edges, except those of small meshes ([`AntumbraSettings::immediate_triangles`]). A frame without events
/// only polls the meshes under construction.
pub(super) fn collect_meshes(
    mut library: ResMut<MeshLibrary>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    meshes: Res<Assets<Mesh>>,
    settings: Res<AntumbraSettings>,
) {
    let library = &mut *library;
    library.changed.clear();
    library.poll();
    for event in events.read() {
        match *event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                if let Some(mesh) = meshes.get(id) {
                    library.convert(id, mesh, settings.immediate_triangles);
                }
            }
            AssetEvent::Removed { id } | AssetEvent::Unused { id } => {
                if library.entries.remove(&id).is_some() {
                    library.changed.push(id);
                }
            }
            AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
}
