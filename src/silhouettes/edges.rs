//! The signed edges between triangles that face the light and triangles that do not.

use std::ops::Range;

use super::contour::{CapMode, Contour, fits};
use super::facing::{FacingBits, MIXED};
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::edge_mesh::{EdgeMesh, EdgeSide, LaneSide};

/// Extracts the edges of a contour: one half of [`extract_contour`](super::extract_contour).
///
/// The multiplicity of a→b is a sum over the triangles at the edge. A triangle that traverses a→b adds +1 if
/// it faces the light; otherwise it is turned and adds −1. A triangle that traverses b→a adds the opposite.
/// Where only back-facing triangles are caps, triangles that face the light add 0; where only facing triangles are,
/// the others add 0, which gives the same sums around closed pieces.
///
/// Cost: the edges of clusters that are mixed or adjoin unlike clusters, one test for every other cluster and
/// seam, a copy of the boundary edges, and the irregular edges. Edges hold vertex indices, and no position is
/// read: copying positions took a third of the time (interior by mesh) and three times the memory.
pub fn extract_edges(mesh: &EdgeMesh, facing: &FacingBits, mode: CapMode, contour: &mut Contour) {
    contour.edges.clear();
    contour.double_edges.clear();
    contour.flush_edges.clear();
    if !fits(mesh, facing) {
        return;
    }
    // The multiplicity of a regular edge between unlike triangles is 1 − (−1) = 2 if all triangles are caps,
    // and 0 − (−1) = 1 − 0 = 1 if only one kind is. An edge joins its triangles into one piece, so the
    // clusters on both sides of a seam are both closed or both open.
    let single = match mode {
        CapMode::ClosedBackFacing | CapMode::ClosedFacing => mesh.closed_cluster_count(),
        CapMode::AllTriangles => 0,
    };
    push_regular(mesh, facing, 0..single, &mut contour.edges);
    push_regular(
        mesh,
        facing,
        single..mesh.clusters().len(),
        &mut contour.double_edges,
    );
    push_boundary(mesh, facing, &mut contour.edges);
    push_irregular(mesh, facing, mode, contour);
}

/// Pushes those regular edges of some clusters whose two triangles differ, in the direction of the triangle
/// that faces the light.
fn push_regular(mesh: &EdgeMesh, facing: &FacingBits, clusters: Range<usize>, edges: &mut Vec<[u32; 2]>) {
    let (words, states) = (facing.words(), facing.states());
    for i in clusters {
        let cluster = &mesh.clusters()[i];
        let word = words[i];
        let corners = &mesh.corners()[cluster.triangles()];
        if states[i] == MIXED {
            let run = &mesh.inner_edges()[cluster.inner()];
            let side = |i: usize| run[i].side;
            let other = |i: usize| word >> (run[i].other_lane % 64);
            push_unlike(word, corners, run.len(), side, other, edges);
        }
        let others = &mesh.seam_clusters()[cluster.seam_clusters()];
        let around = others
            .iter()
            .fold(states[i], |state, &other| state | states[other as usize]);
        if around == MIXED {
            let sides = &mesh.seam_sides()[cluster.seams()];
            let slots = &mesh.seam_slots()[cluster.seams()];
            let side = |i: usize| sides[i];
            let other = |i: usize| {
                let slot = slots[i] as usize;
                words[slot / CLUSTER_TRIANGLES] >> (slot % CLUSTER_TRIANGLES)
            };
            push_unlike(word, corners, sides.len(), side, other, edges);
        }
    }
}

/// Pushes those of `count` edges whose two triangles differ. `side` gives an edge's side in the cluster of
/// `word` and `corners`; the lowest bit of `other` says whether the triangle beyond the edge faces the light.
///
/// Such edges are rare, and no branch predictor can learn where they come, so a first loop only gathers bits.
#[inline(always)]
fn push_unlike(
    word: u64,
    corners: &[[u32; 3]],
    count: usize,
    side: impl Fn(usize) -> LaneSide,
    other: impl Fn(usize) -> u64,
    edges: &mut Vec<[u32; 2]>,
) {
    for first in (0..count).step_by(64) {
        let end = count.min(first + 64);
        let mut unlike = 0u64;
        for i in first..end {
            // Bits enter from above, so every shift but those by lanes is constant.
            unlike = unlike >> 1 | (word >> side(i).lane() ^ other(i)) << 63;
        }
        unlike >>= 64 - (end - first);
        while unlike != 0 {
            let side = side(first + unlike.trailing_zeros() as usize);
            unlike &= unlike - 1;
            let is_facing = word >> side.lane() & 1 != 0;
            edges.push(turned(side.vertices(corners), is_facing));
        }
    }
}

/// Pushes all boundary edges, each in the direction of its triangle once that is turned to face the light.
fn push_boundary(mesh: &EdgeMesh, facing: &FacingBits, edges: &mut Vec<[u32; 2]>) {
    let runs = mesh.boundary_slots().iter().zip(mesh.boundary_vertices());
    edges.extend(runs.map(|(&slot, &edge)| turned(edge, facing.is_facing(slot as usize))));
}

fn push_irregular(mesh: &EdgeMesh, facing: &FacingBits, mode: CapMode, contour: &mut Contour) {
    let closed_slots = mesh.closed_cluster_count() * CLUSTER_TRIANGLES;
    let weight = |side: &EdgeSide| {
        let slot = side.slot() as usize;
        let counts_facing = i32::from(mode == CapMode::AllTriangles || slot >= closed_slots);
        let weight = if facing.is_facing(slot) { counts_facing } else { -1 };
        if side.is_reversed() { -weight } else { weight }
    };
    for (edge, &vertices) in mesh.irregular_vertices().iter().enumerate() {
        let multiplicity: i32 = mesh.irregular_sides(edge).iter().map(weight).sum();
        let vertices = turned(vertices, multiplicity > 0);
        if multiplicity % 2 != 0 {
            contour.edges.push(vertices);
        }
        for _ in 0..multiplicity.unsigned_abs() / 2 {
            contour.double_edges.push(vertices);
        }
    }
}

/// Swaps an edge's vertices unless `is_forward`. Indexing avoids a branch between two copies.
#[inline(always)]
fn turned(edge: [u32; 2], is_forward: bool) -> [u32; 2] {
    [edge[usize::from(!is_forward)], edge[usize::from(is_forward)]]
}
