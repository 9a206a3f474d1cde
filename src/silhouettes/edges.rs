//! The signed edges between triangles that face the light and triangles that do not.

use std::ops::Range;

use glam::Vec3;

use super::contour::{CapMode, Contour, fits};
use super::ends::{Ends, Kept, Resolved};
use super::facing::{FacingBits, MIXED};
use super::planes::FacingPlanes;
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::edge_mesh::{EdgeMesh, EdgeSide};

/// The half of [`extract_contour`](super::extract_contour) that fills the edges.
///
/// The multiplicity of a→b is the sum, over the triangles that traverse it, of +1 if the triangle faces the light
/// and −1 if not (it is turned then), and the reverse for those that traverse b→a. Where only back-facing triangles
/// are caps, those that face the light count 0.
///
/// Cost: the edges of mixed clusters, one test for each other cluster and seam, a copy of the boundary edges, and the
/// irregular edges.
pub fn extract_edges(
    mesh: &EdgeMesh,
    positions: &[Vec3],
    planes: &FacingPlanes,
    facing: &FacingBits,
    mode: CapMode,
    contour: &mut Contour,
) {
    contour.edges.clear();
    if !fits(mesh, positions, facing) {
        return;
    }
    let edges = &mut contour.edges;
    if planes.ends.is_of(mesh) {
        let ends = Kept {
            mesh,
            positions,
            kept: &planes.ends,
        };
        push_edges(mesh, &ends, facing, mode, edges);
    } else {
        let resolve = |vertex: u32| positions[vertex as usize];
        push_edges(mesh, &Resolved { mesh, resolve }, facing, mode, edges);
    }
}

/// Lists the welded vertices of [`Contour::edges`], one to one, for [`link_loops`](super::link_loops). Every vertex
/// starts as many edges as it ends. Apart from the contour, since a volume needs no names.
pub fn extract_edge_vertices(
    mesh: &EdgeMesh,
    facing: &FacingBits,
    mode: CapMode,
    edge_vertices: &mut Vec<[u32; 2]>,
) {
    edge_vertices.clear();
    if facing.words().len() == mesh.clusters().len() {
        let resolve = |vertex| vertex;
        push_edges(mesh, &Resolved { mesh, resolve }, facing, mode, edge_vertices);
    }
}

fn push_edges<E: Ends>(
    mesh: &EdgeMesh,
    ends: &E,
    facing: &FacingBits,
    mode: CapMode,
    edges: &mut Vec<[E::End; 2]>,
) {
    let (words, states) = (facing.words(), facing.states());
    // A regular edge between unlike triangles: +1 + 1 if all triangles are caps, 0 − (−1) if only back-facing ones.
    let copies = |is_closed: bool| match mode {
        CapMode::ClosedBackFacing if is_closed => 1,
        _ => 2,
    };
    for (i, cluster) in mesh.clusters().iter().enumerate() {
        if states[i] == MIXED {
            let copies = copies(i < mesh.closed_cluster_count());
            push_unlike(mesh, ends, cluster.edges(), [words[i]; 2], copies, edges);
        }
    }
    for (i, seam) in mesh.seams().iter().enumerate() {
        let [a, b] = seam.clusters.map(|cluster| cluster as usize);
        if states[a] | states[b] == MIXED {
            let copies = copies(i < mesh.closed_seam_count());
            push_unlike(mesh, ends, seam.edges(), [words[a], words[b]], copies, edges);
        }
    }
    push_boundary(mesh, ends, facing, edges);
    push_irregular(mesh, ends, facing, mode, edges);
}

/// Pushes the regular edges whose two triangles differ, as the one that faces the light traverses them.
///
/// They are rare and come in no order that a branch predictor could learn: a first loop only gathers bits.
///
/// Tried and dropped: a list of hits across clusters and seams, written for every edge and counted for unlike ones, in
/// groups of eight; it took half as long again on the deer.
#[inline(always)]
fn push_unlike<E: Ends>(
    mesh: &EdgeMesh,
    ends: &E,
    range: Range<usize>,
    words: [u64; 2],
    copies: usize,
    edges: &mut Vec<[E::End; 2]>,
) {
    let mut first_edge = range.start;
    for lanes in mesh.regular_lanes()[range].chunks(64) {
        let mut unlike = 0u64;
        for &[first, second] in lanes {
            // Shifted in from above: only constant shifts beside those by lanes.
            unlike = unlike >> 1 | (words[0] >> (first % 64) ^ words[1] >> (second % 64)) << 63;
        }
        unlike >>= 64 - lanes.len();
        while unlike != 0 {
            let i = unlike.trailing_zeros() as usize;
            unlike &= unlike - 1;
            let is_facing = words[0] >> (lanes[i][0] % 64) & 1 != 0;
            let ends = ends.regular(first_edge + i, is_facing);
            for _ in 0..copies {
                edges.push(ends);
            }
        }
        first_edge += lanes.len();
    }
}

/// Pushes all boundary edges, as their triangle traverses them once it is turned to face the light.
fn push_boundary<E: Ends>(mesh: &EdgeMesh, ends: &E, facing: &FacingBits, edges: &mut Vec<[E::End; 2]>) {
    edges.reserve(mesh.boundary_slots().len());
    let open = mesh.closed_cluster_count()..;
    for (cluster, &word) in mesh.clusters()[open.clone()].iter().zip(&facing.words()[open]) {
        let run = cluster.boundary();
        if word == 0 {
            edges.extend(ends.boundary(run, |_| false));
        } else if word == cluster.full_word() {
            edges.extend(ends.boundary(run, |_| true));
        } else {
            let slots = &mesh.boundary_slots()[run.clone()];
            edges.extend(ends.boundary(run, |i| word >> (slots[i] % CLUSTER_TRIANGLES as u32) & 1 != 0));
        }
    }
}

fn push_irregular<E: Ends>(
    mesh: &EdgeMesh,
    ends: &E,
    facing: &FacingBits,
    mode: CapMode,
    edges: &mut Vec<[E::End; 2]>,
) {
    let closed_slots = mesh.closed_cluster_count() * CLUSTER_TRIANGLES;
    let weight = |side: &EdgeSide| {
        let slot = side.slot() as usize;
        let counts_facing = i32::from(mode == CapMode::AllTriangles || slot >= closed_slots);
        let weight = if facing.is_facing(slot) { counts_facing } else { -1 };
        if side.is_reversed() { -weight } else { weight }
    };
    for edge in 0..mesh.irregular_vertices().len() {
        let multiplicity: i32 = mesh.irregular_sides(edge).iter().map(weight).sum();
        if multiplicity != 0 {
            let ends = ends.irregular(edge, multiplicity > 0);
            for _ in 0..multiplicity.unsigned_abs() {
                edges.push(ends);
            }
        }
    }
}
