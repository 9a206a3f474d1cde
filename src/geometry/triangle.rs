//! Distances to triangles.

use glam::DVec3;

/// Distance of a point from a triangle, in the corners' units. Triangles without area count as segments or
/// points.
///
/// Source: Ericson 2004, "Real-Time Collision Detection", section 5.1.5. The signs of products with the edges
/// decide whether the nearest point is a corner, on an edge, or inside.
pub fn distance_to_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let to_segment = |from: DVec3, to: DVec3| {
        let along = to - from;
        let length_sq = along.length_squared();
        let t = if length_sq > 0.0 {
            ((point - from).dot(along) / length_sq).clamp(0.0, 1.0)
        } else {
            0.0
        };
        point.distance(from + along * t)
    };
    let normal = (b - a).cross(c - a);
    let inside = [(a, b), (b, c), (c, a)]
        .into_iter()
        .all(|(from, to)| (to - from).cross(point - from).dot(normal) > 0.0);
    if inside {
        return (point - a).dot(normal).abs() / normal.length();
    }
    to_segment(a, b).min(to_segment(b, c)).min(to_segment(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_edges_and_the_inside_are_near() {
        let triangle = [DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0];
        let distance = |x, y, z| distance_to_triangle(DVec3::new(x, y, z), triangle);
        assert_eq!(distance(0.5, 0.5, 3.0), 3.0);
        assert_eq!(distance(0.5, 0.5, -3.0), 3.0);
        assert_eq!(distance(1.0, -2.0, 0.0), 2.0);
        assert_eq!(distance(-3.0, -4.0, 0.0), 5.0);
        assert!((distance(2.0, 2.0, 0.0) - 2f64.sqrt()).abs() < 1e-12);
        let point = [DVec3::X; 3];
        assert_eq!(distance_to_triangle(DVec3::ZERO, point), 1.0);
    }
}
