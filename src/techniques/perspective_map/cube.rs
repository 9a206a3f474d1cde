//! Several faces: the sides of a box in post-projective space, seen from the light through the box. Together
//! they are a cube map with a displaced centre.
//!
//! A light outside the box has three to five sides behind the box, one inside has six. A ray of light leaves the
//! box through one of them.
//! Source: Kozlov 2004, GPU Gems ch. 14, §14.2.2.

use glam::{DVec3, DVec4};
use smallvec::SmallVec;

use super::light_camera::Rows;
use super::projection::ProjectedLight;

/// Least half side of the box, so that no side is a line.
const LEAST_HALF: f64 = 1e-4;

/// Returns the pictures of the sides behind the points' box that some point is seen through. With `whole` the
/// box is the unit cube.
pub fn sides(light: &ProjectedLight, points: &[DVec3], whole: bool) -> SmallVec<[Rows; 6]> {
    let (mut min, mut max) = (DVec3::splat(-1.0), DVec3::ONE);
    if !whole {
        (min, max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for point in points {
            (min, max) = (min.min(*point), max.max(*point));
        }
    }
    let (middle, half) = (
        (min + max) * 0.5,
        ((max - min) * 0.5).max(DVec3::splat(LEAST_HALF)),
    );
    let mut sides = SmallVec::new();
    for side in 0..6 {
        let Some(rows) = picture(light, middle, half, side / 2, side % 2 == 0) else {
            continue;
        };
        if let Some(rows) = tightened(rows, points) {
            sides.push(rows);
        }
    }
    sides
}

/// Returns the picture of one side, −1 to 1 in x and y, or `None` if the side is in front.
///
/// With P the light, v a point, n the side's outward axis and o its place on it, the point of the side behind v
/// is P + (v − P) · (o − n·P) / (n·v − n·P). Here numerator and denominator are multiplied by the light's w,
/// which may be 0.
fn picture(light: &ProjectedLight, middle: DVec3, half: DVec3, axis: usize, positive: bool) -> Option<Rows> {
    let ProjectedLight { point: at, w } = *light;
    let mut normal = DVec3::ZERO;
    normal[axis] = if positive { 1.0 } else { -1.0 };
    let place = normal.dot(middle) + half[axis];
    let behind = w * place - normal.dot(at);
    if behind <= 1e-9 * (w * place.abs() + at.length()) {
        return None;
    }
    let depth = (normal * w).extend(-normal.dot(at));
    let across = |other: usize| {
        let mut unit = DVec3::ZERO;
        unit[other] = 1.0;
        let row = (normal * at[other] + unit * behind).extend(-at[other] * place) - depth * middle[other];
        row / half[other]
    };
    Some([across((axis + 1) % 3), across((axis + 2) % 3), depth])
}

/// Crops a picture to the points that it shows. Returns `None` if it shows none.
fn tightened(rows: Rows, points: &[DVec3]) -> Option<Rows> {
    let [x, y, w] = rows;
    let clip = |point: &DVec3| [x, y, w].map(|row| row.dot(point.extend(1.0)));
    let sides: [DVec4; 5] = [w, w - x, w + x, w - y, w + y];
    let is_seen = |side: &DVec4| points.iter().any(|point| side.dot(point.extend(1.0)) > 0.0);
    if !sides.iter().all(is_seen) {
        return None;
    }
    let (mut min, mut max) = ([1.0_f64; 2], [-1.0_f64; 2]);
    for point in points {
        let [px, py, pw] = clip(point);
        if pw <= 1e-9 {
            return Some(rows); // it has no place in the picture
        }
        for (axis, place) in [px / pw, py / pw].into_iter().enumerate() {
            min[axis] = min[axis].min(place.max(-1.0));
            max[axis] = max[axis].max(place.min(1.0));
        }
    }
    let window = |row: DVec4, axis: usize| {
        let (middle, half) = ((min[axis] + max[axis]) * 0.5, (max[axis] - min[axis]) * 0.5);
        (row - w * middle) / half.max(LEAST_HALF)
    };
    Some([window(x, 0), window(y, 1), w])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> Vec<DVec3> {
        (0..8)
            .map(|i| DVec3::from_array([0, 1, 2].map(|bit| if i >> bit & 1 == 0 { -1.0 } else { 1.0 })))
            .collect()
    }

    /// Twin of the source's listing 14-1: the point of the cube behind a point, as the light sees it.
    fn on_cube(light: DVec3, point: DVec3) -> DVec3 {
        let positive = DVec3::ONE - light; // d1 … d3
        let negative = light + DVec3::ONE; // d4 … d6
        let from_light = point - light;
        let a = (from_light / positive).max(-from_light / negative).max_element();
        light + from_light / a
    }

    #[test]
    fn a_light_inside_has_six_sides_that_show_what_the_listing_computes() {
        let light = DVec3::new(0.3, -0.2, 0.5);
        let projected = ProjectedLight {
            point: light * 0.7,
            w: 0.7,
        };
        let sides = sides(&projected, &cube(), true);
        assert_eq!(sides.len(), 6);
        for i in 0..500 {
            let at = |k: i32| f64::from((i * k + 5) % 103) / 51.5 - 1.0;
            let point = DVec3::new(at(3), at(7), at(13));
            let expected = on_cube(light, point);
            let shown = sides.iter().enumerate().filter_map(|(side, rows)| {
                let [x, y, w] = rows.map(|row| row.dot(point.extend(1.0)));
                (w > 0.0 && (x / w).abs() < 1.0 && (y / w).abs() < 1.0).then_some((side, x / w, y / w))
            });
            let shown: Vec<_> = shown.collect();
            assert_eq!(shown.len(), 1, "{point}");
            let (side, x, y) = shown[0];
            let axis = side / 2;
            let place = DVec3::new(expected[axis], expected[(axis + 1) % 3], expected[(axis + 2) % 3]);
            assert!((place.x.abs() - 1.0).abs() < 1e-9 && (place.x > 0.0) == (side % 2 == 0));
            assert!((place.y - x).abs() < 1e-9 && (place.z - y).abs() < 1e-9);
        }
    }

    #[test]
    fn a_light_outside_has_three_to_five_sides_and_misses_no_point() {
        let mut counts = [0; 7];
        for i in 0..300 {
            let at = |k: i32| f64::from((i * k + 5) % 103) / 51.5 - 1.0;
            let place = DVec3::new(at(3), at(7), at(13)) * 4.0;
            if place.abs().max_element() < 1.05 {
                continue;
            }
            let w = [1.0, 0.1, 0.0][i as usize % 3];
            let light = ProjectedLight {
                point: if w == 0.0 { place } else { place * w },
                w,
            };
            let sides = sides(&light, &cube(), true);
            counts[sides.len()] += 1;
            for k in 0..40 {
                let inside = DVec3::new(at(17 + k), at(29 + 3 * k), at(11 + 5 * k)) * 0.999;
                let shown = sides.iter().any(|rows| {
                    let [x, y, w] = rows.map(|row| row.dot(inside.extend(1.0)));
                    w > 0.0 && x.abs() <= w * (1.0 + 1e-9) && y.abs() <= w * (1.0 + 1e-9)
                });
                assert!(shown, "{light:?} {inside}");
            }
        }
        assert!(counts[3] > 10 && counts[4] > 10 && counts[5] > 5, "{counts:?}");
        assert_eq!(counts[6], 0);
    }

    #[test]
    fn sides_without_points_are_left_out_and_others_are_tight() {
        let light = ProjectedLight {
            point: DVec3::new(0.0, 0.0, 0.0),
            w: 1.0,
        };
        let corner: Vec<DVec3> = cube()
            .iter()
            .map(|point| (*point + DVec3::splat(3.0)) * 0.2)
            .collect();
        let sides = sides(&light, &corner, true);
        assert_eq!(sides.len(), 3, "the points are in one octant");
        for rows in sides {
            let mut most = f64::MIN;
            for point in &corner {
                let [x, _, w] = rows.map(|row| row.dot(point.extend(1.0)));
                most = most.max(x / w);
            }
            assert!(most >= 0.999, "{most}");
        }
    }
}
