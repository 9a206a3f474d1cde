//! The points that the light's camera must see: bounds of the lit receivers, cut by the view frustum and by a
//! spot light's pyramid.

use glam::{DVec3, DVec4};
use smallvec::SmallVec;

use crate::geometry::Aabb;

/// A face of a convex solid.
type Polygon = SmallVec<[DVec3; 24]>;

/// The corners of each side of a box, in order around the side. The bits of a corner are x, y, z.
const SIDES: [[usize; 4]; 6] = [
    [0, 2, 6, 4],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 3, 7, 6],
    [0, 1, 3, 2],
    [4, 5, 7, 6],
];

/// Returns the corners of a box.
pub fn corners(aabb: &Aabb) -> [DVec3; 8] {
    let (min, max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
    std::array::from_fn(|i| {
        let pick = |bit: usize, axis: usize| if i >> bit & 1 == 0 { min[axis] } else { max[axis] };
        DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
    })
}

/// Adds the corners of the part of a parallelepiped that lies in all half-spaces, each once.
///
/// `corners` are numbered as [`corners`] returns them.
pub fn push_cut(corners: &[DVec3; 8], half_spaces: &[DVec4], points: &mut Vec<DVec3>) {
    let side = |half: &DVec4, point: &DVec3| half.truncate().dot(*point) + half.w;
    let mut cutting: SmallVec<[&DVec4; 20]> = SmallVec::new();
    for half in half_spaces {
        let inside = corners.iter().filter(|point| side(half, point) >= 0.0).count();
        match inside {
            0 => return,
            8 => {}
            _ => cutting.push(half),
        }
    }
    if cutting.is_empty() {
        points.extend_from_slice(corners);
        return;
    }
    let mut solid: SmallVec<[Polygon; 20]> = SIDES
        .iter()
        .map(|side| side.iter().map(|&corner| corners[corner]).collect())
        .collect();
    for half in cutting {
        cut(&mut solid, half);
    }
    // Each corner is on three faces.
    let first = points.len();
    for &point in solid.iter().flatten() {
        if !points[first..].iter().any(|known| is_same(*known, point)) {
            points.push(point);
        }
    }
}

/// Cuts a convex solid by a half-space, and closes it with a face in the plane of the cut.
fn cut(solid: &mut SmallVec<[Polygon; 20]>, half: &DVec4) {
    let side = |point: DVec3| half.truncate().dot(point) + half.w;
    let mut cap = Polygon::new();
    for polygon in solid.iter_mut() {
        let old = std::mem::take(polygon);
        for (i, &to) in old.iter().enumerate() {
            let from = old[(i + old.len() - 1) % old.len()];
            let (at_from, at_to) = (side(from), side(to));
            if (at_from >= 0.0) != (at_to >= 0.0) {
                let crossing = from + (to - from) * (at_from / (at_from - at_to));
                polygon.push(crossing);
                cap.push(crossing);
            }
            if at_to >= 0.0 {
                polygon.push(to);
            }
        }
    }
    solid.retain(|polygon| polygon.len() > 2);
    if cap.len() < 3 {
        return;
    }
    let middle = cap.iter().copied().sum::<DVec3>() / cap.len() as f64;
    let (x, y) = half.truncate().normalize().any_orthonormal_pair();
    let angle = |point: &DVec3| (*point - middle).dot(y).atan2((*point - middle).dot(x));
    cap.sort_unstable_by(|a, b| angle(a).total_cmp(&angle(b)));
    // Each edge that is cut belongs to two faces.
    cap.dedup_by(|a, b| is_same(*a, *b));
    solid.push(cap);
}

/// Whether two corners differ by rounding alone.
fn is_same(a: DVec3, b: DVec3) -> bool {
    a.distance_squared(b) <= 1e-20 * (1.0 + a.length_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn cut_box(half_spaces: &[DVec4]) -> Vec<DVec3> {
        let aabb = Aabb {
            min: Vec3::splat(-1.0),
            max: Vec3::splat(1.0),
        };
        let mut points = Vec::new();
        push_cut(&corners(&aabb), half_spaces, &mut points);
        points
    }

    #[test]
    fn a_box_that_is_not_cut_is_kept_and_one_outside_is_gone() {
        assert_eq!(cut_box(&[DVec4::new(1.0, 0.0, 0.0, 2.0)]).len(), 8);
        assert!(cut_box(&[DVec4::new(1.0, 0.0, 0.0, -2.0)]).is_empty());
    }

    /// The corners of a solid are its points that are farthest in some direction: compared with the box's points that lie
    /// in the half-spaces, on a fine grid.
    #[test]
    fn cut_boxes_reach_as_far_as_their_points() {
        let mut cut_count = 0;
        for i in 0..200 {
            let at = |k: i32| f64::from((i * k + 7) % 101) / 50.5 - 1.0;
            let half_spaces = [
                DVec4::new(at(3), at(5), at(7), 0.5 + 0.3 * at(11)),
                DVec4::new(at(13), at(17), at(19), 0.4 + 0.3 * at(23)),
                DVec4::new(at(29), at(31), at(37), 0.3 + 0.5 * at(41)),
            ];
            let points = cut_box(&half_spaces);
            let inside = |point: &DVec3| {
                half_spaces
                    .iter()
                    .all(|half| half.truncate().dot(*point) + half.w >= -1e-9)
            };
            assert!(
                points
                    .iter()
                    .all(|point| inside(point) && point.abs().max_element() < 1.0 + 1e-9)
            );
            let is_new = |point: &DVec3| point.abs().min_element() < 1.0 - 1e-9;
            cut_count += usize::from(points.iter().any(is_new));
            for (i, point) in points.iter().enumerate() {
                assert!(points[..i].iter().all(|other| !is_same(*other, *point)));
            }
            let step = 1.0 / 12.0;
            let grid = (-12..=12).flat_map(|x| {
                (-12..=12).flat_map(move |y| {
                    (-12..=12).map(move |z| DVec3::new(f64::from(x), f64::from(y), f64::from(z)) * step)
                })
            });
            let grid: Vec<DVec3> = grid.filter(inside).collect();
            for k in 0..12 {
                let direction = DVec3::new(at(43 + k), at(47 + 2 * k), at(53 + k)).normalize_or(DVec3::X);
                let farthest =
                    |points: &[DVec3]| points.iter().map(|p| p.dot(direction)).fold(f64::MIN, f64::max);
                if grid.is_empty() {
                    continue;
                }
                let (exact, sampled) = (farthest(&points), farthest(&grid));
                assert!(exact >= sampled - 1e-9, "{exact} {sampled}");
            }
        }
        assert!(cut_count > 100, "{cut_count}");
    }
}
