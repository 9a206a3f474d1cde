//! Finds triangles that overlap in a set of texture coordinates.

use glam::{DVec2, Vec2};

use crate::geometry::triangle_grid::TriangleGrid;

/// Share of the triangles' size by which they must overlap. Rounding makes neighbours overlap by less.
const SLACK: f64 = 1e-5;

/// Largest number of pairs of triangles that are tested, for each triangle. In usual sets, neighbours alone are tested.
const TESTS_PER_TRIANGLE: usize = 512;

/// Largest number of pairs that are listed in one cell of the grid, for each triangle. A pair may be in several cells, and is
/// tested in one of them. This bounds the time for fans of thousands of slivers, which all meet in a few cells.
const PAIRS_PER_TRIANGLE: usize = 4096;

/// Why a set of texture coordinates cannot hold texels of its own for every place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadCoordinates {
    /// Two triangles overlap.
    Overlap(u32, u32),
    /// A triangle with area in space has none, or is not finite.
    Degenerate(u32),
    /// Coordinates are stretched: a triangle has too few texels along one axis, and so has too much of the surface.
    Stretched(u32),
    /// So many triangles are close to each other that not all pairs are tested for an overlap. None was found until then.
    Crowded,
}

/// Looks for a triangle without an area of its own. Triangles are given by the texture coordinates of their corners, and
/// `None` stands for those that do not count.
pub fn bad_coordinates(triangles: &[Option<[Vec2; 3]>]) -> Option<BadCoordinates> {
    let exact = |corners: &[Vec2; 3]| corners.map(|corner| corner.as_dvec2());
    for (index, corners) in triangles.iter().enumerate() {
        let Some(corners) = corners else { continue };
        let [a, b, c] = exact(corners);
        let area = (b - a).perp_dot(c - a).abs();
        // A NaN is not greater, either.
        if !(area > 1e-14 && area.is_finite()) {
            return Some(BadCoordinates::Degenerate(index as u32));
        }
    }
    let (indices, corners): (Vec<u32>, Vec<[DVec2; 3]>) = (0..)
        .zip(triangles)
        .filter_map(|(index, corners)| Some((index, exact(corners.as_ref()?))))
        .unzip();
    match find_overlap(&corners).outcome {
        Outcome::Apart => None,
        Outcome::Overlap(a, b) => Some(BadCoordinates::Overlap(indices[a], indices[b])),
        Outcome::GivenUp => Some(BadCoordinates::Crowded),
    }
}

/// How a search for an overlap ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// No two triangles overlap.
    Apart,
    /// These two triangles overlap; the first has the lower index.
    Overlap(usize, usize),
    /// There are more pairs than are tested.
    GivenUp,
}

/// A search for an overlap, and its cost.
#[derive(Clone, Copy, Debug)]
struct Search {
    outcome: Outcome,
    /// Number of pairs that were tested.
    tests: usize,
    /// Number of pairs that were found in a cell of the grid.
    pairs: usize,
}

/// Tests the pairs of triangles that share a cell of a grid, up to a bounded number. A pair is tested in the lowest cell that
/// both share, so that it is tested once.
fn find_overlap(triangles: &[[DVec2; 3]]) -> Search {
    let grid = TriangleGrid::new(triangles);
    let lowest: Vec<(usize, usize)> = triangles
        .iter()
        .map(|corners| grid.cells_of(corners)[0])
        .collect();
    let mut search = Search {
        outcome: Outcome::Apart,
        tests: 0,
        pairs: 0,
    };
    for cell in grid.cells() {
        let listed = grid.listed(cell);
        for (place, &second) in listed.iter().enumerate() {
            let second = second as usize;
            for &first in &listed[..place] {
                let first = first as usize;
                let shared = (
                    lowest[first].0.max(lowest[second].0),
                    lowest[first].1.max(lowest[second].1),
                );
                if shared != cell {
                    continue;
                }
                search.tests += 1;
                if overlap(&triangles[first], &triangles[second]) {
                    search.outcome = Outcome::Overlap(first, second);
                    return search;
                }
            }
            search.pairs += place;
            if search.tests > TESTS_PER_TRIANGLE * triangles.len()
                || search.pairs > PAIRS_PER_TRIANGLE * triangles.len()
            {
                search.outcome = Outcome::GivenUp;
                return search;
            }
        }
    }
    search
}

/// Whether two triangles share more than rounding. Source: separating axis theorem, with the normals of all edges.
fn overlap(a: &[DVec2; 3], b: &[DVec2; 3]) -> bool {
    let normals = |corners: &[DVec2; 3]| [0, 1, 2].map(|i| (corners[(i + 1) % 3] - corners[i]).perp());
    let separates = |axis: DVec2| {
        let range = |corners: &[DVec2; 3]| {
            let along = corners.map(|corner| corner.dot(axis));
            let least = along.into_iter().fold(f64::INFINITY, f64::min);
            let most = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
            (least, most)
        };
        let ((a_min, a_max), (b_min, b_max)) = (range(a), range(b));
        let slack = SLACK * (a_max - a_min).min(b_max - b_min);
        a_max - slack <= b_min || b_max - slack <= a_min
    };
    !normals(a).into_iter().chain(normals(b)).any(separates)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(side: u32) -> Vec<Option<[Vec2; 3]>> {
        let at = |x: u32, y: u32| Vec2::new(x as f32, y as f32) / side as f32;
        let cells = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
        cells
            .flat_map(|(x, y)| {
                let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
                [Some([a, b, c]), Some([a, c, d])]
            })
            .collect()
    }

    #[test]
    fn neighbours_do_not_overlap_and_the_moved_one_is_named() {
        let mut triangles = grid(13);
        assert_eq!(bad_coordinates(&triangles), None);
        triangles[40] = triangles[40].map(|corners| corners.map(|corner| corner + Vec2::new(0.01, 0.0)));
        assert!(
            matches!(bad_coordinates(&triangles), Some(BadCoordinates::Overlap(a, b)) if a == 40 || b == 40)
        );
    }

    #[test]
    fn tiled_coordinates_overlap_and_mirrored_ones_too() {
        let one = [Vec2::ZERO, Vec2::X, Vec2::Y];
        let mirrored = [Vec2::ZERO, Vec2::Y, Vec2::X];
        assert_eq!(
            bad_coordinates(&[Some(one), None, Some(one)]),
            Some(BadCoordinates::Overlap(0, 2))
        );
        assert_eq!(
            bad_coordinates(&[Some(one), Some(mirrored)]),
            Some(BadCoordinates::Overlap(0, 1))
        );
        let inside = one.map(|corner| corner * 0.1 + 0.2);
        assert_eq!(
            bad_coordinates(&[Some(one), Some(inside)]),
            Some(BadCoordinates::Overlap(0, 1))
        );
    }

    /// A fan of slivers around the middle of the unit square.
    fn fan(count: u32) -> Vec<Option<[Vec2; 3]>> {
        let rim = |i: u32| {
            let angle = std::f64::consts::TAU * f64::from(i % count) / f64::from(count);
            (DVec2::splat(0.5) + 0.5 * DVec2::from_angle(angle)).as_vec2()
        };
        (0..count)
            .map(|i| Some([Vec2::splat(0.5), rim(i), rim(i + 1)]))
            .collect()
    }

    fn search(triangles: &[Option<[Vec2; 3]>]) -> Search {
        let exact = |corners: &[Vec2; 3]| corners.map(|corner| corner.as_dvec2());
        let corners: Vec<_> = triangles.iter().flatten().map(exact).collect();
        find_overlap(&corners)
    }

    /// Slivers as large as the square are near each other in all pairs. Those of a small fan are all tested, and those of a
    /// large fan are given up after a bounded number of tests.
    #[test]
    fn fans_are_tested_or_given_up_after_a_bounded_number_of_tests() {
        for count in [3, 64, 500, 900] {
            let mut fan = fan(count);
            let search = search(&fan);
            println!("{count}: {search:?}");
            assert_eq!(bad_coordinates(&fan), None, "{count}");
            assert!(search.tests <= (count * count) as usize, "a pair is tested once");
            let last = fan.len() - 1;
            fan[last] =
                fan[last].map(|corners| corners.map(|corner| (corner - 0.5) * 0.9 + Vec2::new(0.4, 0.55)));
            assert!(
                matches!(bad_coordinates(&fan), Some(BadCoordinates::Overlap(_, b)) if b as usize == last),
                "{count}"
            );
        }
        let count = 60_000;
        let large = fan(count as u32);
        let search = search(&large);
        println!("{count}: {search:?}");
        assert_eq!(bad_coordinates(&large), Some(BadCoordinates::Crowded));
        assert!(search.tests <= TESTS_PER_TRIANGLE * count + count, "{search:?}");
        assert!(search.pairs <= PAIRS_PER_TRIANGLE * count + count, "{search:?}");
    }

    /// Tests grow with the number of triangles, not with its square, where triangles are small.
    #[test]
    fn small_triangles_are_tested_with_neighbours_alone() {
        for side in [20, 80, 200] {
            let triangles = grid(side);
            let search = search(&triangles);
            assert_eq!(search.outcome, Outcome::Apart);
            assert!(search.tests < 40 * triangles.len(), "{side}: {search:?}");
        }
    }

    #[test]
    fn triangles_without_area_are_named() {
        let one = [Vec2::ZERO, Vec2::X, Vec2::Y];
        for bad in [
            [Vec2::ONE; 3],
            [Vec2::ZERO, Vec2::X, Vec2::X * 2.0],
            [Vec2::NAN; 3],
            [Vec2::ZERO, Vec2::new(f32::INFINITY, 0.0), Vec2::Y],
        ] {
            assert_eq!(
                bad_coordinates(&[Some(one), Some(bad)]),
                Some(BadCoordinates::Degenerate(1))
            );
        }
    }
}
