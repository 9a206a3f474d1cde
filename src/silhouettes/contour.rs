//! What a shadow volume is made of.

use super::facing::FacingBits;
use crate::geometry::edge_mesh::EdgeMesh;

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

/// Whether bits are of this mesh.
pub(super) fn fits(mesh: &EdgeMesh, facing: &FacingBits) -> bool {
    facing.words().len() == mesh.clusters().len()
}
