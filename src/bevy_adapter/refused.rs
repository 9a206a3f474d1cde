//! Meshes that cannot cast, reported once each.

use bevy::asset::{AssetId, AssetPath};
use bevy::ecs::prelude::*;
use bevy::mesh::Mesh;
use bevy::platform::collections::HashMap;

use super::mesh_convert::MeshRefusal;
use crate::reports::Reports;

/// Meshes that cannot cast shadows and are in use, and why; in the render world.
#[derive(Resource, Debug, Default)]
pub struct RefusedMeshes {
    entries: HashMap<AssetId<Mesh>, Refused>,
}

#[derive(Debug)]
struct Refused {
    why: MeshRefusal,
    /// The first entity that was met with the mesh; it may be gone.
    user: Entity,
    /// Path or id of the asset.
    name: String,
}

impl RefusedMeshes {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.entries.len()
    }

    /// Why a mesh cannot cast.
    pub fn get(&self, mesh: AssetId<Mesh>) -> Option<MeshRefusal> {
        Some(self.entries.get(&mesh)?.why)
    }

    /// Takes note of an entity with such a mesh. The first of several stands for the mesh.
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

    /// Forgets meshes that are gone, or can cast now.
    pub(super) fn resolve(&mut self, changed: &[AssetId<Mesh>], is_refused: impl Fn(AssetId<Mesh>) -> bool) {
        for mesh in changed.iter().filter(|&&mesh| !is_refused(mesh)) {
            self.entries.remove(mesh);
        }
    }

    /// Raises the topic `mesh`.
    pub(super) fn raise(&self, reports: &mut Reports) {
        let mut round = reports.round("mesh");
        for Refused { why, user, name } in self.entries.values() {
            let (code, advice) = advice(why);
            round.raise(Some(*user), code, || {
                format!("The mesh {name} casts no shadow of ours: {why}. {advice}")
            });
        }
    }
}

/// Number of a refusal, and what to do about it. Numbers from 10 on: the renderer has those below.
fn advice(why: &MeshRefusal) -> (u32, &'static str) {
    match why {
        MeshRefusal::RenderWorldOnly => (10, "Load it with `RenderAssetUsages::default()`."),
        MeshRefusal::NoPositions => (11, "Give it positions of three 32-bit floats."),
        MeshRefusal::NotTriangles(_) => (
            12,
            "Use `PrimitiveTopology::TriangleList`, or add `NotShadowCaster` to the entity.",
        ),
        MeshRefusal::Index { .. } => (13, "Repair the triangle's indices, or add the vertices."),
    }
}
