//! What a shadow volume is made of, and its caps.

use super::edges::extract_edges;
use super::facing::{FacingBits, HAS_BACK, HAS_FACING};
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
    /// Welded vertices of the edges that count once, as the cap triangles traverse them once they are turned to face the
    /// light. An edge of multiplicity m is there |m| times, of which each double edge is two.
    pub edges: Vec<[u32; 2]>,
    /// Edges that count twice: those between unlike triangles that both are caps, mostly.
    pub double_edges: Vec<[u32; 2]>,
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
        self.double_edges.clear();
        self.caps.clear();
        self.caps_away_start = 0;
    }

    /// Number of edges, double ones counted twice.
    pub fn edge_count(&self) -> usize {
        self.edges.len() + 2 * self.double_edges.len()
    }

    /// All edges as often as they count, single ones first. Every vertex starts as many as it ends:
    /// [`link_loops`](super::link_loops) makes loops of them.
    pub fn all_edges(&self) -> impl Iterator<Item = [u32; 2]> {
        let double = self.double_edges.iter().flat_map(|&edge| [edge; 2]);
        self.edges.iter().copied().chain(double)
    }
}

/// Extracts edges and caps; the order is that of the mesh, so the same bits give the same contour.
///
/// With bits of another mesh, or none, it is empty. Vertices are named, so that one contour serves whatever pose its
/// bits are of.
pub fn extract_contour(mesh: &EdgeMesh, facing: &FacingBits, mode: CapMode, contour: &mut Contour) {
    extract_edges(mesh, facing, mode, contour);
    extract_caps(mesh, facing, mode, contour);
}

/// The half of [`extract_contour`] that fills the caps.
pub fn extract_caps(mesh: &EdgeMesh, facing: &FacingBits, mode: CapMode, contour: &mut Contour) {
    extract_caps_without(mesh, facing, mode, &[], contour);
}

/// As [`extract_caps`], but for triangles whose bits are set in `left_out`: a word a cluster, or no words for none.
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
    let first_facing = match mode {
        CapMode::ClosedBackFacing => mesh.closed_cluster_count(),
        CapMode::AllTriangles => 0,
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
    for (i, cluster) in mesh.clusters().iter().enumerate() {
        let word = !words[i] & cluster.full_word() & kept(i);
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

pub(super) fn fits(mesh: &EdgeMesh, facing: &FacingBits) -> bool {
    facing.words().len() == mesh.clusters().len()
}
