//! The meshes of the game as shadows need them, by asset.

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

/// A mesh that shadows can be made of.
#[derive(Clone, Debug)]
pub struct ReadyMesh {
    /// Its triangles.
    pub data: Arc<MeshData>,
    /// Its edges; an error: it is lit and casts nothing.
    pub edges: Result<Arc<CasterMesh>, EdgeMeshError>,
}

/// What is known of a mesh.
#[derive(Debug)]
pub enum MeshEntry {
    /// On its way.
    Building(Task<ReadyMesh>),
    /// There.
    Ready(ReadyMesh),
    /// Never.
    Refused(MeshRefusal),
}

/// The meshes of the game, by asset. Written in `PostUpdate`, in
/// [`CollectMeshes`](super::AntumbraMainSystems::CollectMeshes).
#[derive(Resource, Debug, Default)]
pub struct MeshLibrary {
    entries: HashMap<AssetId<Mesh>, MeshEntry>,
    /// Meshes that are on their way.
    building: Vec<AssetId<Mesh>>,
    /// Meshes whose entry became another one in this frame, in the order of their events.
    changed: Vec<AssetId<Mesh>>,
}

impl MeshLibrary {
    /// What is known of a mesh; `None` before its asset is there.
    pub fn get(&self, id: AssetId<Mesh>) -> Option<&MeshEntry> {
        self.entries.get(&id)
    }

    /// Meshes whose entry became another one in this frame.
    pub fn changed(&self) -> &[AssetId<Mesh>] {
        &self.changed
    }

    /// Meshes that are still on their way.
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
                return false; // it was exchanged for one that is there already
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
            // A change that we were not shown the data of: what is known stays as near as anything.
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
        // Under construction too: the old shape casts no shadow of a new one.
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

/// Makes meshes ready that were added or changed, and forgets those that are gone.
///
/// `PostUpdate`, after asset events and before extraction: the last moment in which meshes for the render world alone
/// can be read. Copies vertices here; edges are built on other threads for all but small meshes
/// ([`AntumbraSettings::immediate_triangles`]). Frames without events look at the meshes under construction only.
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
