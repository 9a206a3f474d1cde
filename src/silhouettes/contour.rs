//! The signed edges between triangles that face the light and triangles that do not, and the caps.

use glam::Vec3;

use super::facing::{FacingBits, HAS_BACK, HAS_FACING, MIXED};
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::edge_mesh::{Cluster, EdgeMesh};

/// Which triangles of a caster stand for it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CapMode {
    /// Of closed pieces only the triangles that do not face the light, of open pieces all. Half the caps and sides,
    /// and no cap coincides with a lit face. Right for points outside of closed pieces, if the light is too.
    ///
    /// Idea: Doom 3 BFG.
    #[default]
    ClosedBackFacing,
    /// All triangles: right everywhere, inside of solids as well.
    AllTriangles,
}

/// What the shadow volume of one caster in one light is made of. Buffers are reused.
///
/// Turned to face the light, a cap triangle (a, b, c) bounds an infinite volume: near cap (a, b, c), for each edge
/// a→b the side (b, a, a∞, b∞), far cap (c∞, b∞, a∞), all with their front outward. Sides inside of a patch cancel;
/// `edges` are those that do not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contour {
    /// Positions of the edges, as the cap triangles traverse them once they are turned to face the light. An edge of
    /// multiplicity m is there |m| times.
    pub edges: Vec<[Vec3; 2]>,
    /// Welded vertices of `edges`, one to one. Every vertex starts as many edges as it ends.
    pub edge_vertices: Vec<[u32; 2]>,
    /// Vertices of the cap triangles, three each, in the order of the mesh's corners. First all that are wound
    /// towards the light, then those that are wound away from it and must be turned.
    pub caps: Vec<u32>,
    /// Where in `caps` the latter start.
    pub caps_away_start: usize,
}

impl Contour {
    /// Forgets everything but the memory.
    pub fn clear(&mut self) {
        self.edges.clear();
        self.edge_vertices.clear();
        self.caps.clear();
        self.caps_away_start = 0;
    }

    fn push_edge(&mut self, positions: &[Vec3], [a, b]: [u32; 2], is_forward: bool) {
        let (a, b) = if is_forward { (a, b) } else { (b, a) };
        self.edges.push([positions[a as usize], positions[b as usize]]);
        self.edge_vertices.push([a, b]);
    }
}

/// Extracts edges and caps; the order is that of the mesh, so the same bits give the same contour.
///
/// `positions` are those of the pose that `facing` was classified for. With fewer than
/// [`EdgeMesh::vertex_count`], or bits of another mesh, the contour is empty.
pub fn extract_contour(
    mesh: &EdgeMesh,
    positions: &[Vec3],
    facing: &FacingBits,
    mode: CapMode,
    contour: &mut Contour,
) {
    extract_edges(mesh, positions, facing, mode, contour);
    extract_caps(mesh, positions, facing, mode, contour);
}

/// The half of [`extract_contour`] that fills the edges.
///
/// The multiplicity of a→b is the sum, over the triangles that traverse it, of +1 if the triangle faces the light
/// and −1 if not (it is turned then), and the reverse for those that traverse b→a. Where only back-facing triangles
/// are caps, those that face the light count 0.
///
/// Cost: the edges of mixed clusters, one test for each other cluster and seam, and the irregular edges.
pub fn extract_edges(
    mesh: &EdgeMesh,
    positions: &[Vec3],
    facing: &FacingBits,
    mode: CapMode,
    contour: &mut Contour,
) {
    contour.edges.clear();
    contour.edge_vertices.clear();
    if !fits(mesh, positions, facing) {
        return;
    }
    let (words, states) = (facing.words(), facing.states());
    // A regular edge between unlike triangles: +1 + 1 if all triangles are caps, 0 − (−1) if only back-facing ones.
    let copies = |is_closed: bool| match mode {
        CapMode::ClosedBackFacing if is_closed => 1,
        _ => 2,
    };
    for (i, cluster) in mesh.clusters().iter().enumerate() {
        if states[i] == MIXED {
            let copies = copies(i < mesh.closed_cluster_count());
            push_unlike(mesh, positions, cluster.edges(), [words[i]; 2], copies, contour);
        }
    }
    for (i, seam) in mesh.seams().iter().enumerate() {
        let (a, b) = (seam.clusters[0] as usize, seam.clusters[1] as usize);
        if states[a] | states[b] == MIXED {
            let copies = copies(i < mesh.closed_seam_count());
            push_unlike(
                mesh,
                positions,
                seam.edges(),
                [words[a], words[b]],
                copies,
                contour,
            );
        }
    }
    for (&slot, &edge) in mesh.boundary_slots().iter().zip(mesh.boundary_vertices()) {
        contour.push_edge(positions, edge, facing.is_facing(slot as usize));
    }
    push_irregular(mesh, positions, facing, mode, contour);
}

/// Pushes the regular edges whose two triangles differ, as the one that faces the light traverses them.
fn push_unlike(
    mesh: &EdgeMesh,
    positions: &[Vec3],
    edges: std::ops::Range<usize>,
    words: [u64; 2],
    copies: usize,
    contour: &mut Contour,
) {
    let vertices = &mesh.regular_vertices()[edges.clone()];
    let lanes = &mesh.regular_lanes()[edges];
    // Hits are rare and come in no order that a branch predictor could learn: they are gathered without a branch.
    let mut hits = [0u8; CLUSTER_TRIANGLES];
    for (vertices, lanes) in vertices
        .chunks(CLUSTER_TRIANGLES)
        .zip(lanes.chunks(CLUSTER_TRIANGLES))
    {
        let mut hit_count = 0;
        for (edge, &[first, second]) in (0u8..).zip(lanes) {
            hits[hit_count % CLUSTER_TRIANGLES] = edge;
            hit_count += ((words[0] >> first ^ words[1] >> second) & 1) as usize;
        }
        for &hit in &hits[..hit_count] {
            let is_facing = words[0] >> lanes[hit as usize][0] & 1 != 0;
            for _ in 0..copies {
                contour.push_edge(positions, vertices[hit as usize], is_facing);
            }
        }
    }
}

fn push_irregular(
    mesh: &EdgeMesh,
    positions: &[Vec3],
    facing: &FacingBits,
    mode: CapMode,
    contour: &mut Contour,
) {
    let closed_slots = mesh.closed_cluster_count() * CLUSTER_TRIANGLES;
    for (edge, &vertices) in mesh.irregular_vertices().iter().enumerate() {
        let multiplicity: i32 = mesh
            .irregular_sides(edge)
            .iter()
            .map(|side| {
                let slot = side.slot() as usize;
                let weight = match (facing.is_facing(slot), mode) {
                    (true, CapMode::ClosedBackFacing) if slot < closed_slots => 0,
                    (true, _) => 1,
                    (false, _) => -1,
                };
                if side.is_reversed() { -weight } else { weight }
            })
            .sum();
        for _ in 0..multiplicity.unsigned_abs() {
            contour.push_edge(positions, vertices, multiplicity > 0);
        }
    }
}

/// The half of [`extract_contour`] that fills the caps. `positions` are only counted, so that edges and caps are
/// empty together.
pub fn extract_caps(
    mesh: &EdgeMesh,
    positions: &[Vec3],
    facing: &FacingBits,
    mode: CapMode,
    contour: &mut Contour,
) {
    contour.caps.clear();
    contour.caps_away_start = 0;
    if !fits(mesh, positions, facing) {
        return;
    }
    let first_facing = match mode {
        CapMode::ClosedBackFacing => mesh.closed_cluster_count(),
        CapMode::AllTriangles => 0,
    };
    let (words, states) = (facing.words(), facing.states());
    for (i, cluster) in mesh.clusters().iter().enumerate().skip(first_facing) {
        push_caps(
            mesh,
            cluster,
            words[i],
            states[i] & HAS_FACING != 0,
            &mut contour.caps,
        );
    }
    contour.caps_away_start = contour.caps.len();
    for (i, cluster) in mesh.clusters().iter().enumerate() {
        let word = !words[i] & cluster.full_word();
        push_caps(mesh, cluster, word, states[i] & HAS_BACK != 0, &mut contour.caps);
    }
}

/// Pushes the triangles of a cluster whose bits are set: whole clusters by one copy.
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

fn fits(mesh: &EdgeMesh, positions: &[Vec3], facing: &FacingBits) -> bool {
    positions.len() >= mesh.vertex_count() && facing.words().len() == mesh.clusters().len()
}
