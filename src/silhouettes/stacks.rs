//! The number of casters that lie one behind the other as a light sees them. Techniques that count need room for it.
//!
//! It is an estimate from bounding boxes: half-lines from the light through the centres of boxes count the boxes that they
//! pass. A line also passes boxes of casters that it misses, so the estimate is rarely too low. It is too low where a single
//! connected piece of surface is folded many times, or where boxes overlap only away from their centres.

use glam::{DVec3, DVec4};

use crate::geometry::Aabb;
use crate::geometry::edge_mesh::EdgeMesh;

/// The greatest number of half-lines that are followed.
const LINES: usize = 64;

/// The greatest number of pieces of a mesh whose boxes are kept. A mesh of more pieces keeps none.
const MOST_PIECES: usize = 4096;

/// The largest sum of weights of the boxes that one half-line from the light passes. For a directional light it is a whole
/// line. Cost: [`LINES`] times the boxes.
pub fn stacked_boxes(light: DVec4, boxes: &[(Aabb, u32)]) -> u32 {
    let step = boxes.len().div_ceil(LINES).max(1);
    let from = light.truncate();
    boxes
        .iter()
        .step_by(step)
        .map(|(own, _)| {
            let center = own.center().as_dvec3();
            let (origin, along, first) = if light.w == 0.0 {
                (center, from, f64::NEG_INFINITY)
            } else {
                (from, center - from, 0.0)
            };
            let inverse = along.recip();
            let passed = boxes
                .iter()
                .filter(|(other, _)| passes(other, origin, inverse, first));
            passed.map(|(_, weight)| weight).sum()
        })
        .max()
        .unwrap_or(0)
}

/// Whether the line from `origin` passes the box at a parameter of at least `first`. `inverse` is the reciprocal of the
/// line's direction.
fn passes(aabb: &Aabb, origin: DVec3, inverse: DVec3, first: f64) -> bool {
    let (a, b) = (
        (aabb.min.as_dvec3() - origin) * inverse,
        (aabb.max.as_dvec3() - origin) * inverse,
    );
    // A line within a side's plane gives NaN there, which `min` and `max` pass over.
    let near = a.min(b).to_array().into_iter().fold(first, f64::max);
    let far = a.max(b).to_array().into_iter().fold(f64::INFINITY, f64::min);
    near <= far
}

/// Boxes of the pieces of a mesh; triangles that share a vertex belong to one piece. The list is empty for a mesh of one
/// piece, and for one of very many.
pub fn piece_boxes(mesh: &EdgeMesh, positions: &[glam::Vec3]) -> Vec<Aabb> {
    let mut parents: Vec<u32> = (0..mesh.vertex_count() as u32).collect();
    let root = |parents: &mut Vec<u32>, mut vertex: u32| {
        while parents[vertex as usize] != vertex {
            let grandparent = parents[parents[vertex as usize] as usize];
            parents[vertex as usize] = grandparent;
            vertex = grandparent;
        }
        vertex
    };
    for &[a, b, c] in mesh.corners() {
        let [a, b, c] = [a, b, c].map(|vertex| root(&mut parents, vertex));
        let lowest = a.min(b).min(c);
        for vertex in [a, b, c] {
            parents[vertex as usize] = lowest;
        }
    }
    let mut number_of = vec![u32::MAX; parents.len()];
    let mut boxes: Vec<Aabb> = Vec::new();
    for &vertex in mesh.corners().as_flattened() {
        let root = root(&mut parents, vertex) as usize;
        if number_of[root] == u32::MAX {
            if boxes.len() == MOST_PIECES {
                return Vec::new();
            }
            number_of[root] = boxes.len() as u32;
            boxes.push(Aabb::EMPTY);
        }
        let own = &mut boxes[number_of[root] as usize];
        *own = own.union(Aabb::from_points([positions[vertex as usize]]));
    }
    if boxes.len() == 1 {
        boxes.clear();
    }
    boxes
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn stacks_count_and_fields_do_not() {
        let slab = |height: f32| (Aabb::around(Vec3::Y * height, Vec3::new(1.0, 0.01, 1.0)), 1);
        let stack: Vec<_> = (0..200).map(|i| slab(i as f32 * 0.05)).collect();
        assert_eq!(stacked_boxes(DVec4::new(0.1, 30.0, 0.0, 1.0), &stack), 200);
        assert_eq!(stacked_boxes(DVec4::new(0.0, 1.0, 0.0, 0.0), &stack), 200);
        // Between them only those on the longer way count.
        assert!(stacked_boxes(DVec4::new(0.0, 5.01, 0.0, 1.0), &stack) < 120);
        let crate_at = |i: i32| Vec3::new((i % 20) as f32 * 3.0, 0.0, (i / 20) as f32 * 3.0);
        let field: Vec<_> = (0..400)
            .map(|i| (Aabb::around(crate_at(i), Vec3::splat(0.5)), 1))
            .collect();
        assert!(stacked_boxes(DVec4::new(30.0, 20.0, 31.0, 1.0), &field) < 5);
    }
}
