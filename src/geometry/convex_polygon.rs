//! Convex polygons, given by their corners in order, linear functions that cut them, and the polygons around points.

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

/// The part of the polygon where a linear function is not negative.
///
/// Source: Sutherland & Hodgman 1974, "Reentrant Polygon Clipping".
pub fn clip(corners: &[DVec3], side: impl Fn(DVec3) -> f64) -> SmallVec<[DVec3; 8]> {
    let mut kept = SmallVec::new();
    for (i, &to) in corners.iter().enumerate() {
        let from = corners[(i + corners.len() - 1) % corners.len()];
        kept.extend(crossing(from, to, &side));
        if side(to) >= 0.0 {
            kept.push(to);
        }
    }
    kept
}

/// The two points of the polygon's border where the function is 0. `None` unless there are exactly two.
pub fn chord(corners: &[DVec3], side: impl Fn(DVec3) -> f64) -> Option<[DVec3; 2]> {
    let sides = (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]]);
    let mut crossings = sides.filter_map(|[from, to]| crossing(from, to, &side));
    match (crossings.next(), crossings.next(), crossings.next()) {
        (Some(one), Some(other), None) => Some([one, other]),
        _ => None,
    }
}

fn crossing(from: DVec3, to: DVec3, side: impl Fn(DVec3) -> f64) -> Option<DVec3> {
    let (at_from, at_to) = (side(from), side(to));
    ((at_from >= 0.0) != (at_to >= 0.0)).then(|| from + (to - from) * (at_from / (at_from - at_to)))
}

/// Share of the points' size by which points may be off a plane and still count as flat.
const FLAT: f64 = 1e-4;

/// The plane that fits points best if they are flat.
#[derive(Clone, Copy, Debug)]
pub struct CommonPlane {
    /// The mean of the points.
    pub middle: DVec3,
    /// The unit normal. Which of the two sides it points to is not defined.
    pub normal: DVec3,
    /// The largest distance of a point from the middle.
    size: f64,
}

impl CommonPlane {
    /// Returns the plane of points in any order. `None` if they lie in a line, or one is not finite.
    ///
    /// The plane holds the middle, the farthest point, and the point farthest from the line through those two.
    /// Cost: O(points).
    pub fn of(points: &[DVec3]) -> Option<Self> {
        let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let longest = |vectors: &mut dyn Iterator<Item = DVec3>| {
            vectors.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
        };
        let farthest = longest(&mut points.iter().map(|point| *point - middle))?;
        let size = farthest.length();
        let across = longest(&mut points.iter().map(|point| farthest.cross(*point - middle)))?;
        let has_area = size.is_finite() && across.length() > 1e-9 * size * size;
        let normal = across.try_normalize().filter(|_| has_area)?;
        Some(Self { middle, normal, size })
    }

    /// Whether all points lie in the plane, but for rounding.
    pub fn holds(&self, points: &[DVec3]) -> bool {
        points
            .iter()
            .all(|point| (*point - self.middle).dot(self.normal).abs() <= FLAT * self.size)
    }

    /// Returns the indices of the corners of the convex hull of points in the plane, in order. Points on its border are no
    /// corners.
    #[cfg(any(feature = "gltf", test))]
    pub fn hull(&self, points: &[DVec3]) -> SmallVec<[usize; 8]> {
        let (right, up) = self.normal.any_orthonormal_pair();
        let flat: SmallVec<[DVec2; 8]> = points
            .iter()
            .map(|point| *point - self.middle)
            .map(|from| DVec2::new(right.dot(from), up.dot(from)))
            .collect();
        hull(&flat)
    }
}

/// Returns the indices of the corners of the convex hull of points, counter-clockwise. Of equal points it returns one.
/// Cost: O(n log n).
///
/// Source: Andrew 1979, "Another Efficient Algorithm for Convex Hulls in Two Dimensions".
pub fn hull(points: &[DVec2]) -> SmallVec<[usize; 8]> {
    let mut order: SmallVec<[usize; 8]> = (0..points.len()).collect();
    order.sort_unstable_by(|&a, &b| {
        let (one, other) = (points[a], points[b]);
        let by_place = one.x.total_cmp(&other.x).then(one.y.total_cmp(&other.y));
        by_place.then(a.cmp(&b))
    });
    order.dedup_by(|a, b| points[*a] == points[*b]);
    let turns_left = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a) > 0.0;
    let half = |order: &mut dyn Iterator<Item = usize>| {
        let mut chain: SmallVec<[usize; 8]> = SmallVec::new();
        for next in order {
            while let [.., a, b] = chain[..]
                && !turns_left(points[a], points[b], points[next])
            {
                chain.pop();
            }
            chain.push(next);
        }
        chain.pop();
        chain
    };
    let mut corners = half(&mut order.iter().copied());
    corners.extend(half(&mut order.iter().rev().copied()));
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    const SQUARE: [DVec3; 4] = [
        DVec3::new(0.0, 0.0, 0.0),
        DVec3::new(1.0, 0.0, 0.0),
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::new(0.0, 1.0, 0.0),
    ];

    #[test]
    fn a_corner_is_cut_off() {
        let side = |p: DVec3| 1.5 - p.x - p.y;
        let kept = clip(&SQUARE, side);
        assert_eq!(kept.len(), 5);
        assert!(kept.iter().all(|p| side(*p) >= -1e-12) && !kept.contains(&SQUARE[2]));
        let [one, other] = chord(&SQUARE, side).expect("it is cut");
        assert_eq!(
            (one, other),
            (DVec3::new(1.0, 0.5, 0.0), DVec3::new(0.5, 1.0, 0.0))
        );
    }

    /// Points of a turned grid, 3 by 2 metres, that is shifted from the origin.
    fn grid(side: usize) -> Vec<DVec3> {
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.4);
        let step = |at: usize| at as f64 / (side - 1) as f64;
        let places = (0..side * side).map(|at| (at / side, at % side));
        places
            .map(|(x, y)| turn * DVec3::new(3.0 * step(x), 2.0 * step(y), 0.0) + DVec3::ONE)
            .collect()
    }

    #[test]
    fn the_hull_of_a_grid_has_its_corners() {
        let points = grid(9);
        let plane = CommonPlane::of(&points).expect("a plane");
        assert!(plane.holds(&points));
        let hull = plane.hull(&points);
        let of_grid = [0, 8, 72, 80];
        assert!(of_grid.iter().all(|corner| hull.contains(corner)), "{hull:?}");
        // A turned border is straight but for rounding.
        let on_border = |&at: &usize| at / 9 % 8 == 0 || at % 9 % 8 == 0;
        assert!(hull.iter().all(on_border), "{hull:?}");
        let upright: Vec<DVec2> = (0..81)
            .map(|at| DVec2::new((at / 9) as f64, (at % 9) as f64))
            .collect();
        let mut hull = super::hull(&upright);
        assert_eq!(hull[..], [0, 72, 80, 8], "counter-clockwise");
        let twice = [&upright[..], &upright].concat();
        hull.sort_unstable();
        let mut of_twice = super::hull(&twice);
        of_twice.sort_unstable();
        assert_eq!(of_twice, hull);
    }

    #[test]
    fn only_flat_points_have_a_common_plane() {
        let mut points = grid(3);
        points[4] += DVec3::ONE;
        let plane = CommonPlane::of(&points).expect("a plane");
        assert!(!plane.holds(&points));
        points[4].x = f64::NAN;
        assert!(CommonPlane::of(&points).is_none());
        let line: Vec<DVec3> = (0..5)
            .map(|at| DVec3::new(1.0, 2.0, 3.0) * f64::from(at))
            .collect();
        assert!(CommonPlane::of(&line).is_none() && CommonPlane::of(&[]).is_none());
        assert!(super::hull(&[]).is_empty());
    }

    #[test]
    fn what_is_not_cut_is_kept_or_gone() {
        assert_eq!(clip(&SQUARE, |_| 1.0).len(), 4);
        assert!(clip(&SQUARE, |_| -1.0).is_empty());
        assert!(chord(&SQUARE, |_| 1.0).is_none() && chord(&[], |p| p.x).is_none());
    }
}
