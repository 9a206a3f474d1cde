//! Meshes that cannot cast shadows, each reported once.

use bevy::asset::{AssetId, AssetPath};
use bevy::ecs::prelude::*;
use bevy::mesh::Mesh;
use bevy::platform::collections::HashMap;

use super::mesh_convert::MeshRefusal;
use crate::reports::{Reports, code_of};

/// Meshes that are in use but cannot cast shadows, each with the reason. The resource is in the render world.
#[derive(Resource, Debug, Default)]
pub struct RefusedMeshes {
    entries: HashMap<AssetId<Mesh>, Refused>,
}

#[derive(Debug)]
struct Refused {
    why: MeshRefusal,
    /// First entity that was found to use the mesh. It may have been despawned since.
    user: Entity,
    /// Path of the asset, or its id if it has no path.
    name: String,
}

impl RefusedMeshes {
    /// Returns the number of refused meshes.
    pub fn count(&self) -> usize {
        self.entries.len()
    }

    /// Returns the reason why a mesh cannot cast shadows; `None` if it was not refused.
    pub fn get(&self, mesh: AssetId<Mesh>) -> Option<MeshRefusal> {
        Some(self.entries.get(&mesh)?.why)
    }

    /// Records that an entity uses a refused mesh. If several entities use the mesh, its report names the
    /// first.
    pub(super) fn insert(
        &mut self,
        mesh: AssetId<Mesh>,
        path: Option<&AssetPath>,
        user: Entity,
        why: MeshRefusal,
    ) {
        if self.get(mesh) != Some(why) {
            let name = path.map_or_else(|| mesh.to_string(), ToString::to_string);
            self.entries.insert(mesh, Refused { why, user, name });
        }
    }

    /// Removes those of the changed meshes that are gone or can cast shadows now.
    pub(super) fn resolve(&mut self, changed: &[AssetId<Mesh>], is_refused: impl Fn(AssetId<Mesh>) -> bool) {
        for mesh in changed.iter().filter(|&&mesh| !is_refused(mesh)) {
            self.entries.remove(mesh);
        }
    }

    /// Raises the reports of the topic `mesh`, one for each refused mesh.
    pub(super) fn raise(&self, reports: &mut Reports) {
        let mut round = reports.round("mesh");
        for Refused { why, user, name } in self.entries.values() {
            let (kind, advice) = advice(why);
            round.state(
                Some(*user),
                code_of(kind, name),
                format_args!("The mesh {name} casts no shadow of ours: {why}. {advice}"),
            );
        }
    }
}

/// Returns the kind of a refusal, and advice on how to mend it.
fn advice(why: &MeshRefusal) -> (u32, &'static str) {
    match why {
        MeshRefusal::RenderWorldOnly => (1, "Load it with `RenderAssetUsages::default()`."),
        MeshRefusal::NoPositions => (2, "Give it positions of three 32-bit floats."),
        MeshRefusal::NotTriangles(_) => (
            3,
            "Use `PrimitiveTopology::TriangleList`, or add `NotShadowCaster` to the entity.",
        ),
        MeshRefusal::Index { .. } => (4, "Repair the triangle's indices, or add the vertices."),
    }
}
