//! Pieces of a mesh that are modelled several times in one place.

use super::half_edges::{HalfEdge, edges_of};
use super::pieces::{connected, root};

/// Returns the triangles without the repetitions of pieces, each of whose triangles is there equally often; `None` if no
/// piece is repeated. The same triangle turned over is another one, as in a sheet with a back.
///
/// The copy casts no other shadow, but counts twice where shadows overlap: soft shadows estimate overlaps. A piece of
/// which only a part is repeated stays as it is, because without that part it might no longer be closed.
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
    let mut parents = connected(triangles.len(), half_edges);
    // The least and the greatest number of copies of a triangle, by the root of the piece.
    let mut copies = vec![(u32::MAX, 0u32); triangles.len()];
    for same in order.chunk_by(|a, b| a.0 == b.0) {
        let (least, most) = &mut copies[root(&mut parents, same[0].1) as usize];
        *least = (*least).min(same.len() as u32);
        *most = (*most).max(same.len() as u32);
    }
    let mut stays = vec![true; triangles.len()];
    let mut any = false;
    for same in order.chunk_by(|a, b| a.0 == b.0) {
        let (least, most) = copies[root(&mut parents, same[0].1) as usize];
        if least == most && most > 1 {
            same[1..]
                .iter()
                .for_each(|&(_, triangle)| stays[triangle as usize] = false);
            any = true;
        }
    }
    let left = || triangles.iter().zip(&stays).filter(|(_, stays)| **stays);
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
    fn backs_and_parts_that_are_repeated_stay() {
        let one = solid([0, 1, 2, 3]);
        assert_eq!(without(&one), None);
        let back: Vec<_> = one.iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert_eq!(without(&[one.clone(), back].concat()), None);
        assert_eq!(without(&[one.clone(), vec![one[0]]].concat()), None);
        // Two solids with a common face seen from the same side, and with a common edge.
        assert_eq!(without(&[one.clone(), solid([0, 1, 2, 4])].concat()), None);
        assert_eq!(without(&[one, solid([0, 1, 5, 4])].concat()), None);
    }
}
