//! Nodes whose transform leaves nothing of the meshes at and below them.

use bevy_transform::prelude::GlobalTransform;

use super::mesh::GltfMesh;
use super::nodes::GltfNode;
use super::{Element, Report, SkipKind};
use crate::scene::animation::{AnimationClip, ChannelValues};
use crate::scene::placement::placed;

/// Reports the nodes whose own transform is singular, as far as a mesh is lost by it: one at the node or below it that no
/// skin places. A node whose scale a clip animates is not reported.
pub(super) fn report(nodes: &[GltfNode], meshes: &[GltfMesh], clips: &[AnimationClip], report: &mut Report) {
    let mut parents = vec![None; nodes.len()];
    for (parent, node) in nodes.iter().enumerate() {
        node.children
            .iter()
            .for_each(|&child| parents[child] = Some(parent));
    }
    let mut has_mesh = vec![false; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        let mesh = node
            .mesh
            .filter(|_| node.skin.is_none())
            .and_then(|mesh| meshes.get(mesh));
        let mut at = mesh.filter(|mesh| !mesh.data.indices.is_empty()).map(|_| index);
        while let Some(node) = at.filter(|&node| !has_mesh[node]) {
            has_mesh[node] = true;
            at = parents[node];
        }
    }
    let mut is_scaled = vec![false; nodes.len()];
    for channel in clips.iter().flat_map(|clip| &clip.channels) {
        is_scaled[channel.node] |= matches!(channel.values, ChannelValues::Scale(_));
    }
    for (index, node) in nodes.iter().enumerate() {
        let outer = GlobalTransform::from(node.stretch.unwrap_or_default());
        let placed_from_local = outer * node.transform;
        let affine = placed_from_local.affine();
        // Values that are not finite are reported where they are read.
        let is_finite = affine.is_finite() && affine.matrix3.determinant().is_finite();
        let is_lost = has_mesh[index] && !is_scaled[index];
        if is_finite && is_lost && placed(&placed_from_local, false).is_none() {
            let reason = "its transform is singular";
            report.add(SkipKind::NodeTransform, Element::Node(index), 1, reason);
        }
    }
}
