//! The edges of triangles, sorted so that those between the same vertices are neighbours.

/// One side of a triangle, stored from its lower to its higher vertex.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct HalfEdge {
    pub(super) low: u32,
    pub(super) high: u32,
    /// Twice the triangle's number, plus 1 if the triangle traverses the edge from high to low.
    side: u32,
}

impl HalfEdge {
    pub(super) fn triangle(self) -> u32 {
        self.side >> 1
    }

    pub(super) fn is_reversed(self) -> bool {
        self.side & 1 != 0
    }
}

/// The half edges of all triangles, those of one edge behind one another.
pub(super) fn sorted_half_edges(triangles: &[[u32; 3]]) -> Vec<HalfEdge> {
    let mut half_edges: Vec<HalfEdge> = (0u32..)
        .zip(triangles)
        .flat_map(|(triangle, &[a, b, c])| {
            [(a, b), (b, c), (c, a)].map(|(from, to)| HalfEdge {
                low: from.min(to),
                high: from.max(to),
                side: triangle << 1 | u32::from(from > to),
            })
        })
        .collect();
    half_edges.sort_unstable();
    half_edges
}

/// Yields the half edges of each edge, one edge after another.
pub(super) fn edges_of(half_edges: &[HalfEdge]) -> impl Iterator<Item = &[HalfEdge]> {
    half_edges.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high))
}
