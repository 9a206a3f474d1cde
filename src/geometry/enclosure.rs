//! Whether triangles enclose a point.

use glam::{DVec3, Vec3};

/// The number of times that triangles wind around a point: 1 inside of a closed mesh whose corners run counterclockwise
/// seen from outside, −1 if they run clockwise, 0 outside of it, and a fraction near an open mesh. A triangle whose
/// corners are not finite, or are not in `positions`, counts as absent.
///
/// The result is exact up to rounding except for points on the triangles. O(triangles).
/// Source: Van Oosterom & Strackee 1983, "The Solid Angle of a Plane Triangle"; Jacobson et al. 2013, "Robust
/// Inside-Outside Segmentation Using Generalized Winding Numbers".
pub fn winding_number(positions: &[Vec3], triangles: &[[u32; 3]], point: DVec3) -> f64 {
    let to = |vertex: u32| positions.get(vertex as usize).map(|at| at.as_dvec3() - point);
    let half_angles = triangles.iter().filter_map(|&[a, b, c]| {
        let (a, b, c) = (to(a)?, to(b)?, to(c)?);
        let lengths = [a, b, c].map(DVec3::length);
        let below = lengths.iter().product::<f64>()
            + a.dot(b) * lengths[2]
            + b.dot(c) * lengths[0]
            + c.dot(a) * lengths[1];
        let half_angle = a.dot(b.cross(c)).atan2(below);
        half_angle.is_finite().then_some(half_angle)
    });
    half_angles.sum::<f64>() / std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An octahedron whose corners run counterclockwise seen from outside.
    fn octahedron() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let positions = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        let mut triangles = Vec::new();
        for octant in 0..8u32 {
            let [x, y, z] = [octant & 1, octant >> 1 & 1, octant >> 2];
            let corners = [x, 2 + y, 4 + z];
            let is_mirrored = (x + y + z) % 2 == 1;
            triangles.push(if is_mirrored {
                [corners[0], corners[2], corners[1]]
            } else {
                corners
            });
        }
        (positions.to_vec(), triangles)
    }

    #[test]
    fn it_is_1_inside_and_0_outside() {
        let (positions, triangles) = octahedron();
        let around = |point: DVec3| winding_number(&positions, &triangles, point);
        for point in [DVec3::ZERO, DVec3::new(0.3, -0.2, 0.1), DVec3::new(0.0, 0.9, 0.0)] {
            assert!((around(point) - 1.0).abs() < 1e-9, "{point}: {}", around(point));
        }
        for point in [
            DVec3::new(0.0, 1.1, 0.0),
            DVec3::splat(0.4),
            DVec3::new(1e6, 0.0, 0.0),
        ] {
            assert!(around(point).abs() < 1e-9, "{point}: {}", around(point));
        }
        let turned: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert!((winding_number(&positions, &turned, DVec3::ZERO) + 1.0).abs() < 1e-9);
    }

    #[test]
    fn an_open_mesh_winds_by_a_part_and_bad_triangles_count_as_absent() {
        let plane = [
            Vec3::new(-9.0, 0.0, -9.0),
            Vec3::new(0.0, 0.0, 9.0),
            Vec3::new(9.0, 0.0, -9.0),
        ];
        let below = winding_number(&plane, &[[0, 1, 2]], DVec3::new(0.0, -1e-6, 0.0));
        assert!((below - 0.5).abs() < 1e-3, "{below}");
        let bad = [Vec3::NAN, Vec3::X, Vec3::Y];
        assert_eq!(winding_number(&bad, &[[0, 1, 2], [0, 1, 9]], DVec3::ZERO), 0.0);
    }
}
