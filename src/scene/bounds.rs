//! Where objects are: boxes in local and world space.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;

use super::{PosedMesh, SceneMesh};
use crate::geometry::Aabb;

/// Bounds of the mesh as posed, local space. Empty for a mesh without triangles or finite positions.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct LocalBounds(pub Aabb);

impl Default for LocalBounds {
    fn default() -> Self {
        Self(Aabb::EMPTY)
    }
}

/// Bounds in world space. Empty for an object that is left out: no triangles, or a transform that is not
/// finite or singular.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct WorldBounds(pub Aabb);

impl Default for WorldBounds {
    fn default() -> Self {
        Self(Aabb::EMPTY)
    }
}

/// Whether a transform can be drawn with: finite, and it keeps volume.
pub fn is_usable_transform(transform: &GlobalTransform) -> bool {
    let affine = transform.affine();
    let determinant = affine.matrix3.determinant();
    affine.is_finite() && determinant.is_finite() && determinant != 0.0
}

/// Recomputes [`LocalBounds`] of meshes that were added, exchanged or posed.
///
/// Set: `UpdateBounds`, after [`pose_meshes`](super::pose::pose_meshes). A mesh that is not posed yet has the
/// bounds of its rest pose. Cost: the vertices of changed meshes.
#[allow(clippy::type_complexity, reason = "a query says what the system reads")]
pub fn update_local_bounds(
    mut meshes: Query<
        (&SceneMesh, Option<&PosedMesh>, &mut LocalBounds),
        Or<(Changed<SceneMesh>, Changed<PosedMesh>)>,
    >,
    mut without_mesh: Query<&mut LocalBounds, Without<SceneMesh>>,
) {
    // Its mesh was taken away; the other components stay.
    for mut bounds in &mut without_mesh {
        bounds.set_if_neq(LocalBounds::default());
    }
    for (mesh, posed, mut bounds) in &mut meshes {
        let posed = posed
            .map(|posed| &posed.positions)
            .filter(|posed| posed.len() == mesh.0.positions.len());
        let positions = posed.unwrap_or(&mesh.0.positions);
        let aabb = if mesh.0.indices.is_empty() {
            Aabb::EMPTY
        } else {
            Aabb::from_points(positions.iter().copied())
        };
        bounds.set_if_neq(LocalBounds(aabb));
    }
}

/// Recomputes [`WorldBounds`] of objects whose transform or local bounds changed.
///
/// Set: `UpdateBounds`, after [`update_local_bounds`].
#[allow(clippy::type_complexity, reason = "a query says what the system reads")]
pub fn update_world_bounds(
    mut objects: Query<
        (&LocalBounds, &GlobalTransform, &mut WorldBounds),
        Or<(Changed<LocalBounds>, Changed<GlobalTransform>)>,
    >,
) {
    for (local, transform, mut world) in &mut objects {
        let aabb = if is_usable_transform(transform) {
            local.0.transformed(&transform.affine())
        } else {
            Aabb::EMPTY
        };
        world.set_if_neq(WorldBounds(aabb));
    }
}
