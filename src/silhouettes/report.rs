//! Reports about meshes that cast no shadow, and about shadows that are cast from inside of casters.

use bevy_ecs::prelude::*;

use super::{BuriedOrigins, RefusedCaster};
use crate::geometry::edge_mesh::EdgeMeshError;
use crate::reports::{Reports, code_of};
use crate::scene::{SceneMesh, ShadowCaster};

/// The query of [`report_casters`]: casters whose mesh was refused.
pub type RefusedCasters =
    QueryState<(Entity, &'static RefusedCaster, &'static SceneMesh), With<ShadowCaster>>;

/// Raises the reports of the topic `caster`, one for each caster whose mesh was refused.
pub fn report_casters(world: &World, casters: &mut RefusedCasters, reports: &mut Reports) {
    let mut round = reports.round("caster");
    for (entity, RefusedCaster(error), mesh) in casters.iter(world) {
        let (kind, advice) = advice(error);
        let name = &mesh.0.name;
        round.state(
            Some(entity),
            code_of(kind, name),
            format_args!("The mesh `{name}` casts no shadow: {error}. {advice}"),
        );
    }
}

/// Raises the reports of the topic `shadow_origin`, one for each light whose shadows are cast from inside of a caster.
pub fn report_buried_origins(world: &World, reports: &mut Reports) {
    let mut round = reports.round("shadow_origin");
    for &(light, caster) in &world.resource::<BuriedOrigins>().found {
        let mesh = world.get::<SceneMesh>(caster);
        let name = mesh.map_or("", |mesh| &mesh.0.name);
        round.state(
            Some(light),
            1,
            format_args!(
                "The light's ShadowOrigin lies inside of a caster with the mesh `{name}`, so everything outside of it is \
                 in shadow. Move the origin out, or leave the caster out of `casts_for` of the light's LightSelection."
            ),
        );
    }
}

/// Returns the kind of a mesh's error, and advice on how to mend it.
fn advice(error: &EdgeMeshError) -> (u32, &'static str) {
    match error {
        EdgeMeshError::IndexOutOfRange { .. } => (1, "Repair the triangle's indices, or add the vertices."),
        EdgeMeshError::IncompleteTriangle { .. } => (2, "Give three indices to each triangle."),
        EdgeMeshError::PoseKeyCount { .. } => (3, "Give joints and weights to each vertex, or to none."),
        EdgeMeshError::WeldEpsilon(_) => (4, "Weld by a positive length in metres, or not at all."),
        EdgeMeshError::TooLarge { .. } => (5, "Split the mesh."),
    }
}
