//! The game's meshes, converted for shadows, by asset.

use std::sync::Arc;

use bevy::asset::{AssetEvent, AssetId, Assets};
use bevy::ecs::prelude::*;
use bevy::mesh::Mesh;
use bevy::platform::collections::{HashMap, HashSet};
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
    /// The mesh is being made ready on another thread, for the first time.
    Building,
    /// The mesh is ready. If it changed, this is its last shape that was made ready.
    Ready(ReadyMesh),
    /// The mesh cannot cast shadows.
    Refused(MeshRefusal),
}

/// A mesh that is being made ready on another thread.
#[derive(Debug)]
struct Build {
    task: Task<ReadyMesh>,
    /// The latest data of the mesh, if it changed since the task began. They are built after the task.
    due: Option<MeshData>,
}

/// The game's meshes, by asset. They are updated in `PostUpdate`, in
/// [`CollectMeshes`](super::AntumbraMainSystems::CollectMeshes).
#[derive(Resource, Debug, Default)]
pub struct MeshLibrary {
    entries: HashMap<AssetId<Mesh>, MeshEntry>,
    builds: HashMap<AssetId<Mesh>, Build>,
    /// Meshes whose entry changed in this frame, each once.
    changed: Vec<AssetId<Mesh>>,
    /// The ids in `changed`, to look one up.
    changed_ids: HashSet<AssetId<Mesh>>,
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

    /// Whether the entry of a mesh changed in this frame.
    pub fn has_changed(&self, id: AssetId<Mesh>) -> bool {
        self.changed_ids.contains(&id)
    }

    /// Returns the number of meshes that are being made ready on other threads.
    pub fn building(&self) -> usize {
        self.builds.len()
    }

    /// Whether a mesh, or a later shape of it, is being made ready on another thread.
    pub fn is_building(&self, id: AssetId<Mesh>) -> bool {
        self.builds.contains_key(&id)
    }

    fn poll(&mut self) {
        let Self {
            entries,
            builds,
            changed,
            changed_ids,
        } = self;
        builds.retain(|&id, build| {
            let Some(ready) = block_on(poll_once(&mut build.task)) else {
                return true;
            };
            entries.insert(id, MeshEntry::Ready(ready));
            changed.push(id);
            changed_ids.insert(id);
            let Some(data) = build.due.take() else {
                return false;
            };
            build.task = spawn_build(data);
            true
        });
        changed.sort_unstable(); // a hash map has no order of its own
    }

    fn convert(&mut self, id: AssetId<Mesh>, mesh: &Mesh, immediate_triangles: usize) {
        let data = match convert_mesh(mesh, &format!("mesh {id}")) {
            Ok(data) => data,
            // The mesh changed, but its new data cannot be read. The known shape is the best guess, so it
            // stays.
            Err(MeshRefusal::RenderWorldOnly) if self.is_known(id) => return,
            Err(refusal) => {
                self.builds.remove(&id);
                self.set(id, MeshEntry::Refused(refusal));
                return;
            }
        };
        if data.triangle_count() <= immediate_triangles {
            self.builds.remove(&id);
            self.set(id, MeshEntry::Ready(build(data)));
        } else if let Some(build) = self.builds.get_mut(&id) {
            // The task goes on: a mesh that changes in every frame would otherwise never be ready.
            build.due = Some(data);
        } else {
            let task = spawn_build(data);
            self.builds.insert(id, Build { task, due: None });
            // The shape that a mesh had casts until the new one is ready.
            if !matches!(self.entries.get(&id), Some(MeshEntry::Ready(_))) {
                self.set(id, MeshEntry::Building);
            }
        }
    }

    /// Whether a shape of the mesh is ready, or will be.
    fn is_known(&self, id: AssetId<Mesh>) -> bool {
        self.is_building(id) || matches!(self.entries.get(&id), Some(MeshEntry::Ready(_)))
    }

    fn set(&mut self, id: AssetId<Mesh>, entry: MeshEntry) {
        self.entries.insert(id, entry);
        self.mark_changed(id);
    }

    fn forget(&mut self, id: AssetId<Mesh>) {
        self.builds.remove(&id);
        if self.entries.remove(&id).is_some() {
            self.mark_changed(id);
        }
    }

    fn mark_changed(&mut self, id: AssetId<Mesh>) {
        if self.changed_ids.insert(id) {
            self.changed.push(id);
        }
    }
}

fn spawn_build(data: MeshData) -> Task<ReadyMesh> {
    AsyncComputeTaskPool::get().spawn(async move { build(data) })
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
/// only polls the meshes under construction. A mesh that changed casts its last shape until the new one is ready.
pub(super) fn collect_meshes(
    mut library: ResMut<MeshLibrary>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    meshes: Res<Assets<Mesh>>,
    settings: Res<AntumbraSettings>,
) {
    let library = &mut *library;
    library.changed.clear();
    library.changed_ids.clear();
    library.poll();
    for event in events.read() {
        match *event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                if let Some(mesh) = meshes.get(id) {
                    library.convert(id, mesh, settings.immediate_triangles);
                }
            }
            AssetEvent::Removed { id } | AssetEvent::Unused { id } => library.forget(id),
            AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
}
