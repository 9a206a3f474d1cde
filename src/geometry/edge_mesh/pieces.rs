//! Connected pieces of a mesh, and which of them are closed.

use glam::{DVec3, Vec3};

use super::half_edges::{HalfEdge, edges_of};

/// Whether each triangle belongs to a closed piece. A piece is a set of triangles connected over edges. It is
/// closed if each of its edges is traversed as often in one direction as in the other, and if its signed
/// volume is positive.
///
/// The volume matters because a closed piece casts by its non-facing triangles alone. Let `w(p)` be the
/// number of times that the piece winds around a point `p`. The segment from a point outside the piece to the
/// light crosses `w(light)` more non-facing triangles than facing ones. In a room modelled from within,
/// `w(light)` is −1: everything between a light in the room and a point behind its walls faces the light, so
/// the point would be lit. A piece without volume, such as a card of two opposite triangles, has no inside,
/// so its winding cannot be distinguished from the reverse.
///
/// The sign of the volume does not reveal a piece that is inside out only in part. It is computed from the
/// given positions; a pose may reverse it.
pub(super) fn closed_triangles(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    half_edges: &[HalfEdge],
) -> Vec<bool> {
    let mut parents = connected(triangles.len(), half_edges);
    let mut pieces = vec![Piece::default(); triangles.len()];
    for edge in edges_of(half_edges) {
        let reversed = edge.iter().filter(|half| half.is_reversed()).count();
        if reversed * 2 != edge.len() {
            pieces[root(&mut parents, edge[0].triangle()) as usize].is_open = true;
        }
    }
    for (triangle, corners) in (0u32..).zip(triangles) {
        let piece = root(&mut parents, triangle) as usize;
        // The sum loses little precision relative to a point of the piece, however far the piece is from the
        // origin.
        let origin = positions[triangles[piece][0] as usize].as_dvec3();
        pieces[piece].add(corners.map(|i| positions[i as usize].as_dvec3() - origin));
    }
    (0..triangles.len() as u32)
        .map(|triangle| pieces[root(&mut parents, triangle) as usize].is_closed())
        .collect()
}

#[derive(Clone, Copy, Default)]
struct Piece {
    is_open: bool,
    triangle_count: u32,
    /// Six times the signed volume.
    volume: f64,
    /// Sum of the magnitudes that rounding errors of `volume` are relative to.
    magnitude: f64,
}

impl Piece {
    fn add(&mut self, [a, b, c]: [DVec3; 3]) {
        self.triangle_count += 1;
        self.volume += a.dot(b.cross(c));
        self.magnitude += a.length() * b.length() * c.length();
    }

    fn is_closed(&self) -> bool {
        // A term has less than ten roundings, each at most ε/2 of |a||b||c|. The sum adds one rounding for
        // each term.
        let rounding = f64::EPSILON * (8.0 + f64::from(self.triangle_count));
        !self.is_open && self.volume > rounding * self.magnitude
    }
}

/// Returns a forest of the triangles in which each tree is a piece. [`root`] finds the root of a tree.
pub(super) fn connected(triangle_count: usize, half_edges: &[HalfEdge]) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..triangle_count as u32).collect();
    for edge in edges_of(half_edges) {
        for pair in edge.windows(2) {
            let a = root(&mut parents, pair[0].triangle());
            let b = root(&mut parents, pair[1].triangle());
            parents[a.max(b) as usize] = a.min(b);
        }
    }
    parents
}

/// The lowest triangle of the piece that `triangle` belongs to. Halves the path on the way (union-find).
pub(super) fn root(parents: &mut [u32], mut triangle: u32) -> u32 {
    while parents[triangle as usize] != triangle {
        let grandparent = parents[parents[triangle as usize] as usize];
        parents[triangle as usize] = grandparent;
        triangle = grandparent;
    }
    triangle
}
