//! Query of a caster's shape in this frame: its edges, transform and pose.

use bevy_ecs::query::QueryData;
use glam::{DMat4, Vec3};

use super::casters::{CasterEdges, PosedPlanes};
use super::planes::FacingPlanes;
use crate::scene::placement::Placement;
use crate::scene::{PosedMesh, SceneMesh};

/// The shape of a caster in this frame.
#[derive(QueryData)]
pub struct CasterShape {
    /// Welded edges and triangles of the caster's mesh.
    pub edges: &'static CasterEdges,
    mesh: &'static SceneMesh,
    place: Placement,
    posed: Option<(&'static PosedMesh, &'static PosedPlanes)>,
}

impl CasterShapeItem<'_, '_> {
    /// Returns the matrix from the caster's local space to world space; `None` if its transform leaves it out.
    pub fn world_from_local(&self) -> Option<DMat4> {
        self.place.world_from_local()
    }

    /// Whether the caster's transform flattens it.
    pub fn is_flat(&self) -> bool {
        self.place.is_flat()
    }

    /// Whether the caster has a pose, even one that lacks positions for some vertices.
    pub fn is_posed(&self) -> bool {
        self.posed.is_some()
    }

    /// Returns the pose if it has a position for every vertex.
    fn whole_pose(&self) -> Option<(&PosedMesh, &PosedPlanes)> {
        let vertex_count = self.edges.0.edges.vertex_count();
        self.posed.filter(|(posed, _)| posed.is_whole(vertex_count))
    }

    /// Returns the positions of the caster's vertices, local space. They are those of the pose if it has a
    /// position for every vertex, otherwise those of the mesh.
    pub fn positions(&self) -> &[Vec3] {
        self.whole_pose()
            .map_or(&self.mesh.0.positions, |(posed, _)| &posed.positions)
    }

    /// Returns the planes of the caster's triangles, local space. They fit the positions that
    /// [`CasterShapeItem::positions`] returns.
    pub fn planes(&self) -> &FacingPlanes {
        self.whole_pose()
            .map_or(&self.edges.0.planes, |(_, planes)| &planes.0)
    }
}
