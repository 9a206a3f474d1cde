//! Skins and morph targets: meshes that are posed on the CPU, so that silhouettes, bounds, shadow volumes and
//! the picture all see the same vertices.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{Mat4, Vec3, Vec4};

/// Binds a mesh to joints.
#[derive(Component, Clone, Debug)]
#[require(PosedMesh)]
pub struct Skin {
    /// Joint entities; their `GlobalTransform` is read.
    pub joints: Vec<Entity>,
    /// One for each joint: from the mesh's bind space to the joint's local space.
    pub inverse_bind: Arc<[Mat4]>,
}

/// Weights of the mesh's morph targets.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(PosedMesh)]
pub struct MorphWeights(pub Vec<f32>);

/// The mesh of this frame, in the entity's local space. Written by `pose_meshes`; empty until then.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct PosedMesh {
    /// Metres.
    pub positions: Vec<Vec3>,
    /// Unit length.
    pub normals: Vec<Vec3>,
    /// As [`MeshData::tangents`](super::MeshData::tangents); empty if the mesh has none.
    pub tangents: Vec<Vec4>,
}
