//! The contour of a caster: the edges and caps of which its shadow volume is made.

use super::facing::FacingBits;
use crate::geometry::edge_mesh::EdgeMesh;

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
    /// Closed pieces use only the triangles that face the light; open pieces use all.
    ///
    /// This is for casters that are flattened. Nothing is inside of them, and their lit faces have the depth of those behind,
    /// up to rounding. So the cap must be the lit face itself, which is drawn with exactly the same depths.
    ClosedFacing,
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
    /// Edges of a surface on which the light lies, if there is one. Those that are among the edges above close the contour, and
    /// outline nothing that the light shines past. Each goes from its lower vertex to its higher one; they are sorted. Written
    /// by [`find_flush_edges`](super::find_flush_edges).
    pub flush_edges: Vec<[u32; 2]>,
}

impl Contour {
    /// Empties the contour and keeps its memory.
    pub fn clear(&mut self) {
        self.edges.clear();
        self.double_edges.clear();
        self.caps.clear();
        self.caps_away_start = 0;
        self.flush_edges.clear();
    }

    /// Whether an edge, in either direction, is one of [`Self::flush_edges`].
    pub fn is_flush(&self, [a, b]: [u32; 2]) -> bool {
        self.flush_edges.binary_search(&[a.min(b), a.max(b)]).is_ok()
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

/// Whether the bits are those of this mesh.
pub(super) fn fits(mesh: &EdgeMesh, facing: &FacingBits) -> bool {
    facing.words().len() == mesh.clusters().len()
}
