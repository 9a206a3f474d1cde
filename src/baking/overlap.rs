//! Finds triangles that overlap in a set of texture coordinates.

use std::collections::HashMap;

use glam::{DVec2, Vec2};

/// Share of the triangles' size by which they must overlap. Rounding makes neighbours overlap by less.
const SLACK: f64 = 1e-5;

/// Cells of the grid along each side, for each square root of the number of triangles.
const CELLS: f64 = 1.5;

/// Why a set of texture coordinates cannot hold texels of its own for every place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadCoordinates {
    /// Two triangles overlap.
    Overlap(u32, u32),
    /// A triangle with area in space has none, or is not finite.
    Degenerate(u32),
    /// Coordinates are stretched: a triangle has too few texels along one axis, and so has too much of the surface.
    Stretched(u32),
}

/// Looks for the first triangle without an area of its own. Triangles are given by the texture coordinates of their
/// corners, and `None` stands for those that do not count.
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
    let known: Vec<(u32, [DVec2; 3])> = (0..)
        .zip(triangles)
        .filter_map(|(index, corners)| Some((index, exact(corners.as_ref()?))))
        .collect();
    let all = known.iter().flat_map(|(_, corners)| corners);
    let (min, max) = all.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), corner| {
        (min.min(*corner), max.max(*corner))
    });
    let side = ((known.len() as f64).sqrt() * CELLS).ceil().max(1.0);
    let cell_of = |point: DVec2| ((point - min) / (max - min).max(DVec2::splat(1e-30)) * side).floor();
    let mut cells: HashMap<(i32, i32), Vec<usize>> = HashMap::new();
    for (at, (index, corners)) in known.iter().enumerate() {
        let [a, b, c] = *corners;
        let (low, high) = (cell_of(a.min(b).min(c)), cell_of(a.max(b).max(c)));
        for y in low.y as i32..=high.y as i32 {
            for x in low.x as i32..=high.x as i32 {
                let cell = cells.entry((x, y)).or_default();
                let other = cell.iter().find(|&&other| overlap(corners, &known[other].1));
                if let Some(&other) = other {
                    return Some(BadCoordinates::Overlap(known[other].0, *index));
                }
                cell.push(at);
            }
        }
    }
    None
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
