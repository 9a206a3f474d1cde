//! Extraction of a contour's cap triangles, and of a whole contour with its edges and caps.

use super::contour::{CapMode, Contour, fits};
use super::edges::extract_edges;
use super::facing::{FacingBits, HAS_BACK, HAS_FACING};
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::edge_mesh::{Cluster, EdgeMesh};

/// Extracts the edges and caps of a contour. They are in the order of the mesh, so equal bits give equal
/// contours.
///
/// The contour is empty if the bits do not fit the mesh. It holds vertex indices, not positions. It is valid
/// for the pose from which the bits were computed.
pub fn extract_contour(mesh: &EdgeMesh, facing: &FacingBits, mode: CapMode, contour: &mut Contour) {
    extract_edges(mesh, facing, mode, contour);
    extract_caps(mesh, facing, mode, contour);
}

/// Extracts only the caps of a contour, and leaves its edges as they are. The caps are empty if the bits do
/// not fit the mesh.
pub fn extract_caps(mesh: &EdgeMesh, facing: &FacingBits, mode: CapMode, contour: &mut Contour) {
    extract_caps_without(mesh, facing, mode, &[], contour);
}

/// Extracts the caps of a contour except for triangles whose bits are set in `left_out`. That has one word per
/// cluster, or is empty to leave out none.
pub(super) fn extract_caps_without(
    mesh: &EdgeMesh,
    facing: &FacingBits,
    mode: CapMode,
    left_out: &[u64],
    contour: &mut Contour,
) {
    let kept = |cluster: usize| !left_out.get(cluster).copied().unwrap_or(0);
    contour.caps.clear();
    contour.caps_away_start = 0;
    if !fits(mesh, facing) {
        return;
    }
    let closed_count = mesh.closed_cluster_count();
    let (first_facing, first_averted) = match mode {
        CapMode::ClosedBackFacing => (closed_count, 0),
        CapMode::AllTriangles => (0, 0),
        CapMode::ClosedFacing => (0, closed_count),
    };
    let (words, states) = (facing.words(), facing.states());
    for (i, cluster) in mesh.clusters().iter().enumerate().skip(first_facing) {
        push_caps(
            mesh,
            cluster,
            words[i] & kept(i),
            states[i] & HAS_FACING != 0,
            &mut contour.caps,
        );
    }
    contour.caps_away_start = contour.caps.len();
    for (i, cluster) in mesh.clusters().iter().enumerate().skip(first_averted) {
        let word = !words[i] & cluster.full_word() & kept(i);
        push_caps(mesh, cluster, word, states[i] & HAS_BACK != 0, &mut contour.caps);
    }
}

/// Appends the corners of those triangles of a cluster whose bits are set in `word`. A whole cluster is
/// appended by one copy.
fn push_caps(mesh: &EdgeMesh, cluster: &Cluster, word: u64, is_any_set: bool, caps: &mut Vec<u32>) {
    if !is_any_set {
        return;
    }
    let corners = &mesh.corners()[cluster.triangles()];
    if word == cluster.full_word() {
        caps.extend_from_slice(corners.as_flattened());
        return;
    }
    let mut kept = [[0u32; 3]; CLUSTER_TRIANGLES];
    let mut count = 0;
    for (lane, &corners) in corners.iter().enumerate() {
        kept[count % CLUSTER_TRIANGLES] = corners;
        count += (word >> lane & 1) as usize;
    }
    caps.extend_from_slice(kept[..count].as_flattened());
}
