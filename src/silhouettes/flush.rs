//! Edges of a surface on which a light lies.
//!
//! A surface nearer to a light than its clearance does not block it. Where the surface has several triangles, only those within the
//! clearance are taken out ([`take_out_of_contour`](super::take_out_of_contour)). The light sees the others edge-on, so they block next
//! to nothing, and the edges between them and the gap are no outline of anything. What begins at the surface's rim, such as the other
//! sides of a post, lies behind the surface and darkens nothing before it. Volumes and wedges need all of these edges,
//! because they close the contour. What is drawn outward from a silhouette, as smoothies are, must leave them out: it would
//! reach from the surface into the room that the light shines on.

use glam::Vec3;

use super::grazed::{GrazingLight, each_triangle, is_grazed, reach_along, sides, undirected};
use super::planes::FacingPlanes;
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::distance_to_triangle;
use crate::geometry::edge_mesh::EdgeMesh;

/// Cosine of the angle between normals from which on two planes that pass by the light are one surface.
const PARALLEL: f32 = 0.9999;

/// Finds the edges of all triangles that belong to a surface on which the light lies: triangles within the clearance, and others
/// that lie in the plane of one of these, up to the clearance. Each edge goes from its lower vertex to its higher one, and the
/// edges are sorted.
///
/// `grazed` has the bits that [`find_grazed`](super::find_grazed) writes. Cost: the triangles of the mesh, if any were taken
/// out.
pub fn find_flush_edges(
    mesh: &EdgeMesh,
    planes: &FacingPlanes,
    positions: &[Vec3],
    light: &GrazingLight,
    grazed: &[u64],
    edges: &mut Vec<[u32; 2]>,
) {
    edges.clear();
    if grazed.is_empty() || planes.blocks.len() != mesh.clusters().len() {
        return;
    }
    let plane = |slot: usize| {
        let (block, lane) = (&planes.blocks[slot / CLUSTER_TRIANGLES], slot % CLUSTER_TRIANGLES);
        (
            Vec3::new(block.x[lane], block.y[lane], block.z[lane]),
            block.offset[lane],
        )
    };
    let mut normals: Vec<Vec3> = Vec::new();
    let is_of =
        |normals: &[Vec3], normal: Vec3| normals.iter().any(|other| other.dot(normal).abs() > PARALLEL);
    each_triangle(mesh, |slot, corners| {
        if !is_grazed(grazed, slot) {
            return;
        }
        // Triangles without area have no normal, and are in no plane.
        let Some(normal) = plane(slot).0.try_normalize() else {
            return;
        };
        let corners = corners.map(|i| {
            let local = positions[i as usize].as_dvec3();
            light.world_from_local.transform_point3(local)
        });
        let is_near = || distance_to_triangle(light.light_world.truncate(), corners) <= light.clearance;
        if !is_of(&normals, normal) && is_near() {
            normals.push(normal);
        }
    });
    if normals.is_empty() {
        return;
    }
    let axes = light.clearance_axes();
    let at = light.light_local.truncate();
    each_triangle(mesh, |slot, corners| {
        let (normal, offset) = plane(slot);
        let is_edge_on = (normal.dot(at) + offset).abs() <= reach_along(&axes, normal);
        let normal = normal.try_normalize();
        if is_edge_on && normal.is_some_and(|normal| is_of(&normals, normal)) {
            edges.extend(sides(corners).map(|side| undirected(side).0));
        }
    });
    edges.sort_unstable();
    edges.dedup();
}
