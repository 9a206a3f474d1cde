//! A caster as it stands in this frame: its edges, place and pose.

use bevy_ecs::query::QueryData;
use glam::{DMat4, Vec3};

use super::casters::{CasterEdges, PosedPlanes};
use super::planes::FacingPlanes;
use crate::scene::placement::Placement;
use crate::scene::{PosedMesh, SceneMesh};

/// A caster as it stands in this frame.
#[derive(QueryData)]
pub struct CasterShape {
    /// The welded edges and triangles of its mesh.
    pub edges: &'static CasterEdges,
    mesh: &'static SceneMesh,
    place: Placement,
    posed: Option<(&'static PosedMesh, &'static PosedPlanes)>,
}

impl CasterShapeItem<'_, '_> {
    /// The matrix from its local space to world space; `None` if its transform leaves it out.
    pub fn world_from_local(&self) -> Option<DMat4> {
        self.place.world_from_local()
    }

    /// Whether the caster has a pose, whole or not.
    pub fn is_posed(&self) -> bool {
        self.posed.is_some()
    }

    /// The pose, if it has a position for every vertex.
    fn whole_pose(&self) -> Option<(&PosedMesh, &PosedPlanes)> {
        let is_whole = |posed: &PosedMesh| posed.positions.len() >= self.edges.0.edges.vertex_count();
        self.posed.filter(|(posed, _)| is_whole(posed))
    }

    /// The positions of its vertices, local space: those of the pose once that is whole, else those of the mesh.
    pub fn positions(&self) -> &[Vec3] {
        self.whole_pose()
            .map_or(&self.mesh.0.positions, |(posed, _)| &posed.positions)
    }

    /// The planes of its triangles, local space, of the same pose as [`CasterShapeItem::positions`].
    pub fn planes(&self) -> &FacingPlanes {
        self.whole_pose()
            .map_or(&self.edges.0.planes, |(_, planes)| &planes.0)
    }
}
