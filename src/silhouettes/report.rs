//! Casters that cast nothing, as reports.

use bevy_ecs::prelude::*;

use super::RefusedCaster;
use crate::geometry::edge_mesh::EdgeMeshError;
use crate::reports::Reports;
use crate::scene::{SceneMesh, ShadowCaster};

/// The casters that [`report_casters`] asks for.
pub type RefusedCasters =
    QueryState<(Entity, &'static RefusedCaster, &'static SceneMesh), With<ShadowCaster>>;

/// Raises the topic `caster`.
pub fn report_casters(world: &World, casters: &mut RefusedCasters, reports: &mut Reports) {
    let mut round = reports.round("caster");
    for (entity, RefusedCaster(error), mesh) in casters.iter(world) {
        let (code, advice) = advice(error);
        round.raise(Some(entity), code, || {
            format!("The mesh `{}` casts no shadow: {error}. {advice}", mesh.0.name)
        });
    }
}

/// Number of a mesh's fault, and what to do about it.
fn advice(error: &EdgeMeshError) -> (u32, &'static str) {
    match error {
        EdgeMeshError::IndexOutOfRange { .. } => (1, "Repair the triangle's indices, or add the vertices."),
        EdgeMeshError::IncompleteTriangle { .. } => (2, "Give three indices to each triangle."),
        EdgeMeshError::PoseKeyCount { .. } => (3, "Give joints and weights to each vertex, or to none."),
        EdgeMeshError::WeldEpsilon(_) => (4, "Weld by a positive length in metres, or not at all."),
        EdgeMeshError::TooLarge { .. } => (5, "Split the mesh."),
    }
}
