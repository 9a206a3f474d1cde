//! The contour of a caster: the edges and caps of which its shadow volume is made.

use super::edges::extract_edges;
use super::facing::{FacingBits, HAS_BACK, HAS_FACING};
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::edge_mesh::{Cluster, EdgeMesh};

/// Which triangles of a caster its shadow volume is built from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CapMode {
    /// Closed pieces use only the triangles that do not face the light; open pieces use all.
    ///
    /// This halves caps and sides, and no cap coincides with a lit face. It is right for points outside of
    /// closed pieces, if the light is outside too. Idea: Doom 3 BFG.
    #[default]
    ClosedBackFacing,
    /// All triangles are used. This is right everywhere, also inside of solids.
    AllTriangles,
}

/// The edges and caps that make the shadow volume of one caster in one light. Buffers are reused.
///
/// A cap triangle (a, b, c), turned to face the light, bounds an infinite volume of near cap (a, b, c), a
/// side (b, a, a∞, b∞) for each edge a→b, and far cap (c∞, b∞, a∞), all with their front outward. The sides
/// inside of a patch cancel; `edges` are those that do not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contour {
    /// Welded vertices of the edges that count once, in the direction of the cap triangles once they are
    /// turned to face the light. An edge of multiplicity m occurs |m| times in total, where a double edge
    /// stands for two.
    pub edges: Vec<[u32; 2]>,
    /// Edges that count twice: mostly those between unlike triangles that are both caps.
    pub double_edges: Vec<[u32; 2]>,
    /// Vertices of the cap triangles, three each, in the order of the mesh's corners. Triangles wound towards
    /// the light come first; after them come those wound away from it, which must be turned.
    pub caps: Vec<u32>,
    /// Index into `caps` of the first triangle that is wound away from the light.
    pub caps_away_start: usize,
}

impl Contour {
    /// Empties the contour and keeps its memory.
    pub fn clear(&mut self) {
        self.edges.clear();
        self.double_edges.clear();
        self.caps.clear();
        self.caps_away_start = 0;
    }

    /// Number of edges, where a double edge counts twice.
    pub fn edge_count(&self) -> usize {
        self.edges.len() + 2 * self.double_edges.len()
    }

    /// Iterates over all edges with their multiplicity, single edges first. At every vertex as many edges
    /// start as end, so [`link_loops`](super::link_loops) can make loops of them.
    pub fn all_edges(&self) -> impl Iterator<Item = [u32; 2]> {
        let double = self.double_edges.iter().flat_map(|&edge| [edge; 2]);
        self.edges.iter().copied().chain(double)
    }
}

/// Extracts edges and caps. They come in the order of the mesh, so the same bits give the same contour.
///
/// The contour is empty if the bits are not those of this mesh. It holds vertex indices, so it serves for the
/// pose from which its bits were computed.
pub fn extract_contour(mesh: &EdgeMesh, facing: &FacingBits, mode: CapMode, contour: &mut Contour) {
    extract_edges(mesh, facing, mode, contour);
    extract_caps(mesh, facing, mode, contour);
}

/// Extracts the caps of a contour: one half of [`extract_contour`].
pub fn extract_caps(mesh: &EdgeMesh, facing: &FacingBits, mode: CapMode, contour: &mut Contour) {
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

/// Pushes the triangles of a cluster whose bits are set. A whole cluster takes one copy.
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
