//! Triangles of a mesh that are modelled several times in one place.

use super::half_edges::{HalfEdge, edges_of};
use super::pieces::{connected, root};

/// Returns the triangles without their repetitions; `None` if there are none. The same triangle turned over is another
/// one, as in a sheet with a back. A piece that would no longer be closed without its repetitions keeps them, as two
/// solids do that have a face in common.
///
/// A copy casts no other shadow, but counts twice where shadows overlap: soft shadows estimate overlaps.
pub(super) fn without_repeats(triangles: &[[u32; 3]], half_edges: &[HalfEdge]) -> Option<Vec<[u32; 3]>> {
    let runs_alike = |edge: &[HalfEdge]| match edge {
        [] | [_] => false,
        [a, b] => a.is_reversed() == b.is_reversed(),
        _ => true,
    };
    if !edges_of(half_edges).any(runs_alike) {
        return None; // each copy of a triangle runs along its edges once more
    }
    let mut order: Vec<([u32; 3], u32)> = (0u32..)
        .zip(triangles)
        .map(|(triangle, &corners)| (lowest_first(corners), triangle))
        .collect();
    order.sort_unstable();
    let mut is_copy = vec![false; triangles.len()];
    for same in order.chunk_by(|a, b| a.0 == b.0) {
        for &(_, triangle) in &same[1..] {
            is_copy[triangle as usize] = true;
        }
    }
    // Whether a piece has an open edge with its copies, and without them, by the triangle at the piece's root.
    let mut is_open = vec![[false; 2]; triangles.len()];
    let mut parents = connected(triangles.len(), half_edges);
    for edge in edges_of(half_edges) {
        let mut balance = [0i32; 2];
        for half in edge {
            let direction = if half.is_reversed() { -1 } else { 1 };
            balance[0] += direction;
            balance[1] += direction * i32::from(!is_copy[half.triangle() as usize]);
        }
        let piece = &mut is_open[root(&mut parents, edge[0].triangle()) as usize];
        *piece = [0, 1].map(|way| piece[way] || balance[way] != 0);
    }
    for (triangle, is_copy) in (0u32..).zip(&mut is_copy) {
        *is_copy &= is_open[root(&mut parents, triangle) as usize] != [false, true];
    }
    let left = || triangles.iter().zip(&is_copy).filter(|(_, is_copy)| !**is_copy);
    let any = is_copy.contains(&true);
    any.then(|| left().map(|(corners, _)| *corners).collect())
}

/// Turns a triangle so that its lowest corner is the first. Its winding stays the same.
fn lowest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

#[cfg(test)]
mod tests {
    use super::super::half_edges::sorted_half_edges;
    use super::*;

    /// A tetrahedron on these corners.
    fn solid([a, b, c, d]: [u32; 4]) -> Vec<[u32; 3]> {
        vec![[a, b, c], [a, c, d], [a, d, b], [b, d, c]]
    }

    fn without(triangles: &[[u32; 3]]) -> Option<Vec<[u32; 3]>> {
        without_repeats(triangles, &sorted_half_edges(triangles))
    }

    #[test]
    fn copies_of_a_piece_are_left_out() {
        let (one, other) = (solid([0, 1, 2, 3]), solid([4, 5, 6, 7]));
        let turned: Vec<_> = one.iter().map(|&[a, b, c]| [b, c, a]).collect();
        let thrice = [one.clone(), other.clone(), turned.clone(), turned].concat();
        assert_eq!(without(&thrice), Some([one.clone(), other.clone()].concat()));
        let each_twice = [one.clone(), one.clone(), other.clone(), other.clone()].concat();
        assert_eq!(without(&each_twice), Some([one, other].concat()));
    }

    #[test]
    fn copies_of_a_part_are_left_out() {
        let (one, apart) = (solid([0, 1, 2, 3]), solid([5, 6, 7, 8]));
        let part = vec![one[0], one[2], one[2]];
        let all = [one.clone(), part, apart.clone()].concat();
        assert_eq!(without(&all), Some([one.clone(), apart].concat()));
        // A solid that is there twice and touches another one along an edge.
        let beside = solid([0, 1, 5, 4]);
        let all = [one.clone(), beside.clone(), one.clone()].concat();
        assert_eq!(without(&all), Some([one.clone(), beside].concat()));
        // A part that is open with and without the copy.
        let open = one[1..].to_vec();
        assert_eq!(without(&[open.clone(), vec![one[1]]].concat()), Some(open));
    }

    #[test]
    fn backs_and_what_closes_a_piece_stay() {
        let one = solid([0, 1, 2, 3]);
        assert_eq!(without(&one), None);
        let back: Vec<_> = one.iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert_eq!(without(&[one.clone(), back].concat()), None);
        // Two solids with a common face seen from the same side, and with a common edge.
        assert_eq!(without(&[one.clone(), solid([0, 1, 2, 4])].concat()), None);
        assert_eq!(without(&[one, solid([0, 1, 5, 4])].concat()), None);
    }
}
