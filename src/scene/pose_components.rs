//! Components of posed meshes: joints, weights of morph targets, and the posed vertices.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{Mat4, Vec3, Vec4};

use super::churn::count_churn;

/// Binds a mesh to joints. Removing this component returns the mesh to its rest pose.
///
/// The joints alone decide where the mesh is. The entity's own transform decides which sides are fronts: give it a
/// negative scale if the joints mirror the mesh.
#[derive(Component, Clone, Debug)]
#[require(PosedMesh)]
pub struct Skin {
    /// Joint entities. Their `GlobalTransform` is read.
    pub joints: Vec<Entity>,
    /// Inverse bind matrices, one for each joint: from the mesh's bind space to the joint's local space. A
    /// missing matrix counts as the identity.
    pub inverse_bind: Arc<[Mat4]>,
}

/// Weights of the mesh's morph targets. A weight that is missing or not finite counts as 0.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(PosedMesh)]
pub struct MorphWeights(pub Vec<f32>);

/// The posed vertices of this frame, in the entity's local space. They are empty until [`pose_meshes`](super::pose_meshes) has
/// run once. From then on there is one entry for each vertex of the mesh.
///
/// Change detection marks this component exactly in frames in which [`pose_meshes`](super::pose_meshes) posed the mesh anew:
/// after [`SceneMesh`](super::SceneMesh), [`Skin`] or [`MorphWeights`] changed, and for a skinned mesh also after the
/// `GlobalTransform` of a joint or of the entity itself changed. The triangles remain those of the mesh.
#[derive(Component, Clone, Debug, Default, PartialEq)]
#[component(on_add = count_churn, on_remove = count_churn)]
pub struct PosedMesh {
    /// Posed position of each vertex, metres, local space.
    pub positions: Vec<Vec3>,
    /// Posed unit normal of each vertex, local space.
    pub normals: Vec<Vec3>,
    /// Posed tangents, in the layout of [`MeshData::tangents`](super::MeshData::tangents). Empty if the mesh
    /// has none.
    pub tangents: Vec<Vec4>,
}

impl PosedMesh {
    /// Whether the pose has a position for each vertex of a mesh. Until then the mesh itself counts.
    pub(crate) fn is_whole(&self, vertex_count: usize) -> bool {
        self.positions.len() == vertex_count
    }
}
