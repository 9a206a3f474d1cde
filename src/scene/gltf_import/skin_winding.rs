//! Whether a skin turns its mesh inside out.

use bevy_transform::prelude::Transform;
use glam::{Mat3, Vec3};

use super::LoadedGltf;
use super::nodes::GltfSkin;
use crate::scene::MeshData;

/// Whether the joints of a skin mirror most of its mesh while the nodes stand as in the file. `parent` gives the parent
/// of a node in the scene.
///
/// Fronts of a mirrored mesh wind clockwise (glTF 2.0 §3.7.4). Of a skinned mesh the joints alone decide: each mirrors
/// by the sign of the determinant of its global transform times its inverse bind matrix, and counts by its weights.
pub(super) fn mirrors(
    gltf: &LoadedGltf,
    skin: &GltfSkin,
    mesh: &MeshData,
    parent: impl Fn(usize) -> Option<usize>,
) -> bool {
    let is_mirrored = |joint: usize| {
        let mut odd = false;
        let mut at = Some(joint);
        while let Some(node) = at {
            let node_data = &gltf.nodes[node];
            odd ^=
                mirrors_space(&node_data.transform) ^ node_data.stretch.as_ref().is_some_and(mirrors_space);
            at = parent(node);
        }
        odd
    };
    let binds = skin.joints.iter().zip(&*skin.inverse_bind);
    let signs: Vec<f64> = binds
        .map(|(&joint, bind)| {
            let bind_mirrors = Mat3::from_mat4(*bind).as_dmat3().determinant() < 0.0;
            if is_mirrored(joint) == bind_mirrors {
                1.0
            } else {
                -1.0
            }
        })
        .collect();
    let mut balance = 0.0;
    for (joints, weights) in mesh.joints.iter().zip(&mesh.joint_weights) {
        for (&joint, weight) in joints.iter().zip(weights.to_array()) {
            balance += f64::from(weight) * signs.get(usize::from(joint)).copied().unwrap_or(0.0);
        }
    }
    balance < 0.0
}

/// Whether a transform mirrors. A scale of 0 counts as a positive one, since animation may still change it.
fn mirrors_space(transform: &Transform) -> bool {
    transform.scale.cmplt(Vec3::ZERO).bitmask().count_ones() % 2 == 1
}
