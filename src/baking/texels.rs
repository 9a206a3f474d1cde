//! The texels of a chart, and the surface point that each stands for.

use glam::{DVec2, DVec3, UVec2};

use super::chart::Chart;

/// Texels that blending may read around a point lie within one texel of it along both axes.
const REACH: f64 = 1.0;

/// Largest distance of such a texel from the surface. A texel within reach of one point of a slanted rim may be nearest to
/// another point, out of reach along one axis.
const FAR: f64 = REACH * std::f64::consts::SQRT_2;

/// Distance from the rim at which texels beyond the rim look for the light, texels. On the rim itself a wall that stands
/// there touches the point, and what touches a point does not shadow it.
const INSET: f64 = 1.0 / 16.0;

/// A texel and the point of the surface that it stands for: its centre, or for a texel beyond the rim the nearest point
/// within.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texel {
    /// Place in the chart.
    pub at: UVec2,
    /// Index among the triangles of the chart.
    pub triangle: u32,
    /// Barycentric weights of the triangle's corners.
    pub weights: DVec3,
}

/// The nearest point so far of a texel.
#[derive(Clone, Copy)]
struct Nearest {
    distance: f64,
    triangle: u32,
    weights: DVec3,
}

/// Lists the texels of a chart that hold the surface or its rim, in rows.
pub fn texels_of(chart: &Chart) -> Vec<Texel> {
    let size = chart.size;
    let mut nearest: Vec<Option<Nearest>> = vec![None; size.element_product() as usize];
    for (index, triangle) in (0u32..).zip(&chart.triangles) {
        let corners = triangle.texels.map(|corner| corner.as_dvec2());
        let [a, b, c] = corners;
        if (b - a).perp_dot(c - a) == 0.0 {
            continue;
        }
        let low = (a.min(b).min(c) - REACH - 0.5)
            .floor()
            .max(DVec2::ZERO)
            .as_uvec2();
        let high = (a.max(b).max(c) + REACH + 0.5).ceil().as_uvec2().min(size);
        for y in low.y..high.y {
            for x in low.x..high.x {
                let at = (y * size.x + x) as usize;
                let center = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
                let known = nearest[at].map_or(f64::INFINITY, |known| known.distance);
                if known == 0.0 {
                    continue;
                }
                let (distance, point) = nearest_point(center, &corners);
                if distance < known && distance < FAR {
                    nearest[at] = Some(Nearest {
                        distance,
                        triangle: index,
                        weights: weights_at(inset(point, distance, &corners), &corners),
                    });
                }
            }
        }
    }
    let texel = |(at, nearest): (usize, Option<Nearest>)| {
        let nearest = nearest?;
        Some(Texel {
            at: UVec2::new(at as u32 % size.x, at as u32 / size.x),
            triangle: nearest.triangle,
            weights: nearest.weights,
        })
    };
    nearest.into_iter().enumerate().filter_map(texel).collect()
}

/// The point of a triangle nearest to `point`, and how far it is.
fn nearest_point(point: DVec2, corners: &[DVec2; 3]) -> (f64, DVec2) {
    let weights = weights_at(point, corners);
    if weights.min_element() >= 0.0 {
        return (0.0, point);
    }
    let on_side = |side: usize| {
        let (from, to) = (corners[side], corners[(side + 1) % 3]);
        let along = to - from;
        let t = ((point - from).dot(along) / along.length_squared().max(1e-30)).clamp(0.0, 1.0);
        let nearest = from + along * t;
        (nearest.distance(point), nearest)
    };
    let sides = [on_side(0), on_side(1), on_side(2)];
    sides
        .into_iter()
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or((0.0, point))
}

/// Moves a point from the rim into the triangle.
fn inset(point: DVec2, distance: f64, corners: &[DVec2; 3]) -> DVec2 {
    if distance == 0.0 {
        return point;
    }
    let inward = (corners[0] + corners[1] + corners[2]) / 3.0 - point;
    let length = inward.length();
    point + inward * (INSET.min(0.5 * length) / length.max(1e-30))
}

/// Barycentric weights of a point. Their sum is 1.
fn weights_at(point: DVec2, [a, b, c]: &[DVec2; 3]) -> DVec3 {
    let area = (*b - *a).perp_dot(*c - *a);
    let of_a = (*b - point).perp_dot(*c - point) / area;
    let of_b = (*c - point).perp_dot(*a - point) / area;
    DVec3::new(of_a, of_b, 1.0 - of_a - of_b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baking::chart::{ChartTriangle, PADDING};
    use glam::Vec2;

    fn square(side: f32) -> Chart {
        turned_square(side, 0.0)
    }

    /// A place on a square, given by shares of its sides.
    fn on_square(share: Vec2, side: f32, degrees: f32) -> Vec2 {
        let turn = Vec2::from_angle(degrees.to_radians());
        let left = turn.y * side; // that much of the square is left of its corner
        turn.rotate(share * side) + Vec2::new(left, 0.0) + PADDING as f32
    }

    fn turned_square(side: f32, degrees: f32) -> Chart {
        let at = |x: f32, y: f32| on_square(Vec2::new(x, y), side, degrees);
        let [a, b, c, d] = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        let extent = side * (degrees.to_radians().sin() + degrees.to_radians().cos());
        let triangle = |triangle, texels| ChartTriangle { triangle, texels };
        Chart {
            surface: 0,
            size: UVec2::splat(extent.ceil() as u32 + 2 * PADDING),
            triangles: vec![triangle(0, [a, b, c]), triangle(1, [a, c, d])],
            coarser: None,
        }
    }

    fn place(chart: &Chart, texel: &Texel) -> DVec2 {
        let corners = chart.triangles[texel.triangle as usize]
            .texels
            .map(|corner| corner.as_dvec2());
        let weights = texel.weights.to_array();
        (0..3).map(|i| corners[i] * weights[i]).sum()
    }

    #[test]
    fn texels_inside_stand_for_their_centres_and_those_of_the_rim_for_the_nearest_point() {
        let chart = square(8.0);
        let texels = texels_of(&chart);
        assert_eq!(texels.len(), 100, "eight rows of eight, and a rim of one");
        for texel in &texels {
            let center = texel.at.as_dvec2() + 0.5;
            let place = place(&chart, texel);
            let nearest = center.clamp(DVec2::splat(2.0), DVec2::splat(10.0));
            let slack = if nearest == center { 1e-9 } else { INSET * 1.01 };
            assert!(place.distance(nearest) <= slack, "{center} {place}");
        }
    }

    #[test]
    fn every_texel_that_blending_reads_is_there() {
        let squares = [0.3, 1.0, 5.7, 8.49].map(|side| [0.0, 20.0, 45.0, 77.0].map(|turn| (side, turn)));
        for (side, degrees) in squares.into_iter().flatten() {
            let chart = turned_square(side, degrees);
            let texels = texels_of(&chart);
            let is_there = |at: UVec2| texels.iter().any(|texel| texel.at == at);
            for step in 0..400 {
                let share = Vec2::new((step % 20) as f32, (step / 20) as f32) / 19.0;
                let corner = (on_square(share, side, degrees) - 0.5).floor().as_uvec2();
                for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    assert!(
                        is_there(corner + UVec2::new(x, y)),
                        "{side} {degrees}: {corner} of {share}"
                    );
                }
            }
        }
    }
}
