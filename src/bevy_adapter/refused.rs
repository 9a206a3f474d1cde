//! Meshes that cannot cast, told of once each.

use bevy::asset::{AssetId, AssetPath};
use bevy::ecs::prelude::*;
use bevy::mesh::Mesh;
use bevy::platform::collections::HashMap;

use super::mesh_convert::MeshRefusal;

/// Meshes that cannot cast shadows and are in use, and why; in the render world.
#[derive(Resource, Debug, Default)]
pub struct RefusedMeshes {
    entries: HashMap<AssetId<Mesh>, MeshRefusal>,
    warnings: usize,
}

/// A game that makes such meshes in every frame has heard it by then.
const MAX_WARNINGS: usize = 32;

impl RefusedMeshes {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.entries.len()
    }

    /// Why a mesh cannot cast.
    pub fn get(&self, mesh: AssetId<Mesh>) -> Option<MeshRefusal> {
        self.entries.get(&mesh).copied()
    }

    /// Warns of a mesh the first time that it is met.
    pub(super) fn report(
        &mut self,
        mesh: AssetId<Mesh>,
        path: Option<&AssetPath>,
        user: Entity,
        why: MeshRefusal,
    ) {
        if self.entries.insert(mesh, why) == Some(why) || self.warnings >= MAX_WARNINGS {
            return;
        }
        self.warnings += 1;
        let name = path.map_or_else(|| mesh.to_string(), ToString::to_string);
        let last = if self.warnings == MAX_WARNINGS {
            " (of further meshes nothing is said)"
        } else {
            ""
        };
        tracing::warn!("mesh {name} of entity {user} casts no shadow: {why}{last}");
    }

    /// Forgets meshes that are gone, or can cast now.
    pub(super) fn resolve(&mut self, changed: &[AssetId<Mesh>], is_refused: impl Fn(AssetId<Mesh>) -> bool) {
        for mesh in changed.iter().filter(|&&mesh| !is_refused(mesh)) {
            self.entries.remove(mesh);
        }
    }
}
