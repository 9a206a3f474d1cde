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
    let regular = |edge| ends.regular(edge);
    let mut hits = Hits::new();
    // A regular edge between unlike triangles: +1 + 1 if all triangles are caps, 0 − (−1) if only back-facing ones.
    let closed_copies = match mode {
        CapMode::ClosedBackFacing => 1,
        CapMode::AllTriangles => 2,
    };
    let closed = mesh.closed_cluster_count();
    for (part, copies) in [(0..closed, closed_copies), (closed..mesh.clusters().len(), 2)] {
        for i in part {
            if states[i] == MIXED {
                collect_unlike(
                    mesh,
                    mesh.clusters()[i].edges(),
                    [words[i]; 2],
                    &mut hits,
                    |hits| hits.flush(copies, regular, edges),
                );
            }
        }
        hits.flush(copies, regular, edges);
    }
    let closed = mesh.closed_seam_count();
    let (closed, open) = mesh.seams().split_at(closed);
    for (part, copies) in [(closed, closed_copies), (open, 2)] {
        // Which seams matter is no less random than which edges do.
        let mut unlike = [0u8; 64];
        for seams in part.chunks(unlike.len()) {
            let mut unlike_count = 0;
            for (i, seam) in (0u8..).zip(seams) {
                let [a, b] = seam.clusters.map(|cluster| states[cluster as usize]);
                unlike[unlike_count % 64] = i;
                unlike_count += usize::from(a | b == MIXED);
            }
            for &i in &unlike[..unlike_count] {
                let seam = &seams[usize::from(i)];
                let words = seam.clusters.map(|cluster| words[cluster as usize]);
                collect_unlike(mesh, seam.edges(), words, &mut hits, |hits| {
                    hits.flush(copies, regular, edges)
                });
            }
        }
        hits.flush(copies, regular, edges);
    }
    push_boundary(mesh, ends, facing, edges);
    push_irregular(mesh, ends, facing, mode, &mut hits, edges);
}

/// Edges to be pushed, as edge · 2 + whether forward. They are rare and come in no order that a branch predictor could
/// learn, so that each edge is written here and only counted if it is wanted.
struct Hits {
    edges: [u32; Hits::CAPACITY],
    count: usize,
}

impl Hits {
    const CAPACITY: usize = 256;
    /// Flushed with less room than that.
    const SLACK: usize = 8;

    fn new() -> Self {
        Self {
            edges: [0; Self::CAPACITY],
            count: 0,
        }
    }

    fn is_full(&self) -> bool {
        self.count > Self::CAPACITY - Self::SLACK
    }

    fn flush<T: Copy>(&mut self, copies: usize, ends: impl Fn(usize) -> [T; 2], edges: &mut Vec<[T; 2]>) {
        let hits = &self.edges[..self.count];
        for _ in 0..copies {
            edges.extend(
                hits.iter()
                    .map(|&hit| turned(ends(hit as usize >> 1), hit & 1 != 0)),
            );
        }
        self.count = 0;
    }
}

/// Collects the regular edges whose two triangles differ, as the one that faces the light traverses them.
fn collect_unlike(
    mesh: &EdgeMesh,
    range: Range<usize>,
    words: [u64; 2],
    hits: &mut Hits,
    mut flush: impl FnMut(&mut Hits),
) {
    let all_lanes = mesh.regular_lanes();
    for first_edge in range.clone().step_by(Hits::SLACK) {
        // Always as many: most seams are short, and a loop of another length each time cannot be predicted.
        let lanes = match all_lanes[first_edge..].first_chunk() {
            Some(lanes) => *lanes,
            None => std::array::from_fn(|i| all_lanes.get(first_edge + i).copied().unwrap_or_default()),
        };
        let edge_count = (range.end - first_edge).min(Hits::SLACK);
        collect_chunk(first_edge as u32, edge_count, &lanes, words, hits);
        if hits.is_full() {
            flush(hits);
        }
    }
}

#[inline(always)]
fn collect_chunk(
    first_edge: u32,
    edge_count: usize,
    lanes: &[[u8; 2]; Hits::SLACK],
    words: [u64; 2],
    hits: &mut Hits,
) {
    for (i, &[first, second]) in lanes.iter().enumerate() {
        let is_facing = words[0] >> (first % 64) & 1;
        let is_unlike = (is_facing ^ words[1] >> (second % 64)) & u64::from(i < edge_count) & 1;
        hits.edges[hits.count % Hits::CAPACITY] = (first_edge + i as u32) << 1 | is_facing as u32;
        hits.count += is_unlike as usize;
    }
}

/// Pushes all boundary edges, as their triangle traverses them once it is turned to face the light.
fn push_boundary<E: Ends>(mesh: &EdgeMesh, ends: &E, facing: &FacingBits, edges: &mut Vec<[E::End; 2]>) {
    edges.reserve(mesh.boundary_slots().len());
    let open = mesh.closed_cluster_count()..;
    for (cluster, &word) in mesh.clusters()[open.clone()].iter().zip(&facing.words()[open]) {
        let run = cluster.boundary();
        if word == 0 {
            edges.extend(ends.boundary(run).map(|[a, b]| [b, a]));
        } else if word == cluster.full_word() {
            edges.extend(ends.boundary(run));
        } else {
            let slots = &mesh.boundary_slots()[run.clone()];
            edges.extend(slots.iter().zip(ends.boundary(run)).map(|(slot, edge)| {
                let is_facing = word >> (slot % CLUSTER_TRIANGLES as u32) & 1 != 0;
                turned(edge, is_facing)
            }));
        }
    }
}

fn push_irregular<E: Ends>(
    mesh: &EdgeMesh,
    ends: &E,
    facing: &FacingBits,
    mode: CapMode,
    hits: &mut Hits,
    edges: &mut Vec<[E::End; 2]>,
) {
    let closed_slots = mesh.closed_cluster_count() * CLUSTER_TRIANGLES;
    let weight = |side: &EdgeSide| {
        let slot = side.slot() as usize;
        let counts_facing = i32::from(mode == CapMode::AllTriangles || slot >= closed_slots);
        let weight = if facing.is_facing(slot) { counts_facing } else { -1 };
        if side.is_reversed() { -weight } else { weight }
    };
    let irregular = |edge| ends.irregular(edge);
    for edge in 0..mesh.irregular_vertices().len() {
        let multiplicity: i32 = mesh.irregular_sides(edge).iter().map(weight).sum();
        let hit = (edge as u32) << 1 | u32::from(multiplicity > 0);
        let mut copies = multiplicity.unsigned_abs() as usize;
        // Rarely more than the slack.
        while copies > Hits::SLACK {
            edges.push(turned(irregular(edge), multiplicity > 0));
            copies -= 1;
        }
        hits.edges[hits.count..hits.count + 4].fill(hit);
        if copies > 4 {
            hits.edges[hits.count + 4..hits.count + Hits::SLACK].fill(hit);
        }
        hits.count += copies;
        if hits.is_full() {
            hits.flush(1, irregular, edges);
        }
    }
    hits.flush(1, irregular, edges);
}

fn turned<T>([a, b]: [T; 2], is_forward: bool) -> [T; 2] {
    if is_forward { [a, b] } else { [b, a] }
}
