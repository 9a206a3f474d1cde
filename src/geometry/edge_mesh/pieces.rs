//! Which triangles hang together, and which pieces are closed.

use glam::{DVec3, Vec3};

use super::half_edges::{HalfEdge, edges_of};

/// Whether each triangle's piece is closed: triangles connected over edges, each edge traversed as often in one
/// direction as in the other, around a volume that is positive.
///
/// The volume matters because only triangles that do not face the light stand for a closed piece. With `w` the number
/// of times that the piece winds around a point, the segment from a point outside to the light crosses as many
/// triangles of either kind, plus `w(light)` that do not face the light. In a room modelled from within `w(light)` is
/// −1: all that is between a light in it and a point behind its walls faces the light, and the point would be lit. A
/// piece without volume, as a card of two opposite triangles, has no inside that could tell its winding from its
/// reverse.
///
/// The sign of the sum cannot tell a piece that is inside out in part; and it is that of the positions given, a pose
/// may turn it.
pub(super) fn closed_triangles(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    half_edges: &[HalfEdge],
) -> Vec<bool> {
    let mut parents: Vec<u32> = (0..triangles.len() as u32).collect();
    for edge in edges_of(half_edges) {
        for pair in edge.windows(2) {
            let a = root(&mut parents, pair[0].triangle());
            let b = root(&mut parents, pair[1].triangle());
            parents[a.max(b) as usize] = a.min(b);
        }
    }
    let mut pieces = vec![Piece::default(); triangles.len()];
    for edge in edges_of(half_edges) {
        let reversed = edge.iter().filter(|half| half.is_reversed()).count();
        if reversed * 2 != edge.len() {
            pieces[root(&mut parents, edge[0].triangle()) as usize].is_open = true;
        }
    }
    for (triangle, corners) in (0u32..).zip(triangles) {
        let piece = root(&mut parents, triangle) as usize;
        // Near the piece the sum loses little, however far the piece is from the origin.
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
    /// What rounding errors are relative to.
    magnitude: f64,
}

impl Piece {
    fn add(&mut self, [a, b, c]: [DVec3; 3]) {
        self.triangle_count += 1;
        self.volume += a.dot(b.cross(c));
        self.magnitude += a.length() * b.length() * c.length();
    }

    fn is_closed(&self) -> bool {
        // A term has less than ten roundings, each at most ε/2 of |a||b||c|; the sum has one for each term.
        let rounding = f64::EPSILON * (8.0 + f64::from(self.triangle_count));
        !self.is_open && self.volume > rounding * self.magnitude
    }
}

/// The lowest triangle of a piece; halves the path on the way.
fn root(parents: &mut [u32], mut triangle: u32) -> u32 {
    while parents[triangle as usize] != triangle {
        let grandparent = parents[parents[triangle as usize] as usize];
        parents[triangle as usize] = grandparent;
        triangle = grandparent;
    }
    triangle
}
