//! Whether a mesh is nowhere inside out. If so, its fronts hide from outside everything that lies within it.

use glam::{DMat3, DVec2, DVec3, Vec3};

use crate::geometry::triangle_grid::TriangleGrid;

/// The greatest number of tests for each triangle. A mesh that needs more counts as inside out somewhere.
const TESTS_PER_TRIANGLE: usize = 512;

/// Whether no point has a negative winding number. Then every ray from outside meets a front first. The signed volume would
/// show this for a ball, but not for a mesh that is partly inside out.
///
/// A region of negative winding number has a triangle on its border. So it is enough to walk along one direction through
/// every triangle's centre and to count the triangles that are passed. The direction is askew, so that no model has sides
/// along it. A walk whose count does not end at 0 has met an edge or a hole and is ignored.
///
/// Cost: each triangle's cell of a grid across the direction, once when the mesh is built.
pub fn is_outside_out(positions: &[Vec3], triangles: &[[u32; 3]]) -> bool {
    let askew = DMat3::from_axis_angle(DVec3::new(0.36, 0.48, 0.8).normalize(), 1.234_567);
    let place = |i: u32| positions.get(i as usize).map(|p| askew * p.as_dvec3());
    let corners: Option<Vec<[DVec3; 3]>> = triangles
        .iter()
        .map(|&[a, b, c]| Some([place(a)?, place(b)?, place(c)?]))
        .collect();
    let Some(corners) = corners else {
        return false;
    };
    let seen: Vec<[DVec2; 3]> = corners
        .iter()
        .map(|corners| corners.map(DVec3::truncate))
        .collect();
    let grid = TriangleGrid::new(&seen);
    let mut tests = 0;
    let mut passed: Vec<(f64, i32)> = Vec::new();
    for own in &corners {
        let center = (own[0] + own[1] + own[2]) / 3.0;
        passed.clear();
        for &other in grid.at(center.truncate()) {
            tests += 1;
            if let Some(crossing) = crossing(&corners[other as usize], center.truncate()) {
                passed.push(crossing);
            }
        }
        if tests > TESTS_PER_TRIANGLE * triangles.len() {
            return false;
        }
        if passed.iter().map(|(_, sign)| sign).sum::<i32>() != 0 {
            continue;
        }
        // The walk starts above. Of two triangles in one place, the one that is entered comes first.
        let near = grid.size().max_element() * 1e-9;
        passed.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut number = 0;
        for same in passed.chunk_by(|a, b| a.0 - b.0 <= near) {
            number += same.iter().map(|(_, sign)| sign).sum::<i32>();
            if number < 0 {
                return false;
            }
        }
    }
    true
}

/// The height at which a walk at a place passes a triangle, and 1 if it enters through its front, else −1. `None` if it
/// misses the triangle.
fn crossing([a, b, c]: &[DVec3; 3], at: DVec2) -> Option<(f64, i32)> {
    let side = |from: DVec3, to: DVec3| (to - from).truncate().perp_dot(at - from.truncate());
    let weights = [side(*b, *c), side(*c, *a), side(*a, *b)];
    let area: f64 = weights.iter().sum();
    let inside = weights.iter().all(|w| *w > 0.0) || weights.iter().all(|w| *w < 0.0);
    let height = (a.z * weights[0] + b.z * weights[1] + c.z * weights[2]) / area;
    inside.then_some((height, if area > 0.0 { 1 } else { -1 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of eight corners, wound outward or inward.
    fn push_box(
        center: Vec3,
        half: Vec3,
        inward: bool,
        positions: &mut Vec<Vec3>,
        triangles: &mut Vec<[u32; 3]>,
    ) {
        let first = positions.len() as u32;
        positions.extend((0..8).map(|i| {
            let sign = |bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
            center + half * Vec3::new(sign(1), sign(2), sign(4))
        }));
        let sides = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        for [a, b, c, d] in sides {
            for [a, b, c] in [[a, b, c], [a, c, d]] {
                let corners = if inward { [a, c, b] } else { [a, b, c] };
                triangles.push(corners.map(|i| first + i));
            }
        }
    }

    fn boxes(boxes: &[(Vec3, f32, bool)]) -> bool {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for &(center, half, inward) in boxes {
            push_box(center, Vec3::splat(half), inward, &mut positions, &mut triangles);
        }
        is_outside_out(&positions, &triangles)
    }

    #[test]
    fn what_is_inside_out_in_part_is_found() {
        assert!(boxes(&[(Vec3::ZERO, 1.0, false)]));
        assert!(boxes(&[(Vec3::ZERO, 1.0, false), (Vec3::X * 1.5, 1.0, false)]));
        assert!(
            boxes(&[(Vec3::ZERO, 1.0, false), (Vec3::ZERO, 0.5, true)]),
            "a cavity"
        );
        assert!(!boxes(&[(Vec3::ZERO, 1.0, true)]));
        assert!(!boxes(&[(Vec3::ZERO, 1.0, false), (Vec3::X * 3.0, 0.2, true)]));
        assert!(
            !boxes(&[(Vec3::ZERO, 1.0, false), (Vec3::X, 0.5, true)]),
            "a dent that sticks out"
        );
    }

    #[test]
    fn one_piece_twisted_into_two_lobes_is_found() {
        // A prism whose far end is turned round: its volume is that of the larger part.
        let ring = |z: f32, size: f32| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| Vec3::new(x * size, y * size, z))
        };
        let prism = |size: f32| {
            let positions: Vec<Vec3> = ring(-2.0, 1.0).into_iter().chain(ring(1.0, size)).collect();
            let mut triangles = vec![[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]];
            for i in 0..4u32 {
                let j = (i + 1) % 4;
                triangles.extend([[i, j, j + 4], [i, j + 4, i + 4]]);
            }
            is_outside_out(&positions, &triangles)
        };
        assert!(prism(0.6));
        // Through a point and out again: mirrored in both directions it is as it was, in one it is inside out.
        assert!(prism(-0.6));
        let mirrored = {
            let far = ring(1.0, 0.6).map(|p| Vec3::new(-p.x, p.y, p.z));
            let positions: Vec<Vec3> = ring(-2.0, 1.0).into_iter().chain(far).collect();
            let mut triangles = vec![[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]];
            for i in 0..4u32 {
                let j = (i + 1) % 4;
                triangles.extend([[i, j, j + 4], [i, j + 4, i + 4]]);
            }
            is_outside_out(&positions, &triangles)
        };
        assert!(!mirrored);
    }
}
