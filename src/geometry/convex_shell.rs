//! Whether a mesh lies on the surface of a convex body, as the walls of a room and a sky dome do.

use glam::{DVec3, Vec3};

use super::Aabb;

/// Most tests for each triangle, one for each vertex. Meshes with more vertices count as not convex.
const TESTS_PER_TRIANGLE: usize = 2048;

/// Distance of a vertex from a triangle's plane that counts as rounding, as a share of the size of the mesh.
const ROUNDING: f64 = 1e-5;

/// Returns a point inside of the convex body on whose surface a mesh lies: the mean of its vertices. `None` unless all vertices
/// lie on one side of each triangle's plane, and no plane holds them all. The mesh need not be closed, and its triangles may
/// wind either way.
///
/// Triangles without area do not count. O(triangles × vertices), but most meshes that are not convex end at an early triangle.
pub fn middle_of_shell(positions: &[Vec3], triangles: &[[u32; 3]]) -> Option<Vec3> {
    let mut vertices: Vec<u32> = triangles.as_flattened().to_vec();
    vertices.sort_unstable();
    vertices.dedup();
    if vertices.len() < 4 || vertices.len() > TESTS_PER_TRIANGLE {
        return None;
    }
    let place = |vertex: u32| positions.get(vertex as usize).map(|at| at.as_dvec3());
    let places = vertices.into_iter().map(place).collect::<Option<Vec<DVec3>>>()?;
    if !places.iter().all(|place| place.is_finite()) {
        return None;
    }
    let bounds = Aabb::from_points(places.iter().map(|place| place.as_vec3()));
    let rounding = ROUNDING * 2.0 * f64::from(bounds.half_size().length());
    let supports = |corners: &[u32; 3]| {
        let (Some(a), Some(b), Some(c)) = (place(corners[0]), place(corners[1]), place(corners[2])) else {
            return false;
        };
        let Some(normal) = (b - a).cross(c - a).try_normalize() else {
            return true;
        };
        let (mut below, mut above) = (false, false);
        for place in &places {
            let height = normal.dot(*place - a);
            below |= height < -rounding;
            above |= height > rounding;
            if below && above {
                return false;
            }
        }
        below || above
    };
    let is_shell = rounding.is_finite() && triangles.iter().all(supports);
    let sum: DVec3 = places.iter().sum();
    is_shell.then(|| (sum / places.len() as f64).as_vec3())
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUADS: [[u32; 4]; 6] = [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];

    fn room() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let corners = Aabb::around(Vec3::new(1.0, 2.0, 3.0), Vec3::new(3.0, 1.5, 2.0));
        let corner = |index: u32| {
            let pick = |bit: u32| index >> bit & 1 == 1;
            Vec3::new(
                if pick(0) { corners.max.x } else { corners.min.x },
                if pick(1) { corners.max.y } else { corners.min.y },
                if pick(2) { corners.max.z } else { corners.min.z },
            )
        };
        let triangles = QUADS.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        ((0..8).map(corner).collect(), triangles.collect())
    }

    fn is_convex_shell(positions: &[Vec3], triangles: &[[u32; 3]]) -> bool {
        middle_of_shell(positions, triangles).is_some()
    }

    #[test]
    fn rooms_are_convex_whole_or_open_and_wound_either_way() {
        let (positions, mut triangles) = room();
        assert!(is_convex_shell(&positions, &triangles));
        triangles.truncate(9);
        triangles[2].swap(0, 1);
        triangles.push([1, 1, 2]);
        assert!(is_convex_shell(&positions, &triangles));
    }

    #[test]
    fn plates_dents_and_furniture_are_not() {
        let (mut positions, mut triangles) = room();
        assert!(!is_convex_shell(&positions, &triangles[..2]), "a plate");
        let mut dented = positions.clone();
        dented[7] = Vec3::new(1.0, 2.0, 3.0);
        assert!(!is_convex_shell(&dented, &triangles), "a dent");
        dented[7].y = f32::NAN;
        assert!(!is_convex_shell(&dented, &triangles), "no number");
        positions.extend([Vec3::ONE, Vec3::new(1.5, 1.0, 1.0), Vec3::new(1.0, 1.0, 1.5)]);
        triangles.push([8, 9, 10]);
        assert!(!is_convex_shell(&positions, &triangles), "a plate inside");
        triangles.push([0, 1, 99]);
        assert!(!is_convex_shell(&positions, &triangles), "no such vertex");
        assert!(!is_convex_shell(&[], &[]));
    }
}
