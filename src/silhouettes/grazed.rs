//! Triangles in or on which a light lies. They block nothing.
//!
//! The plane of such a triangle contains the light, up to rounding. So it is chance which side faces the light. Its
//! outline may surround the light, and pushed away from the light it covers half of space. Lamps flush with a ceiling and
//! lights that an editor snapped to a wall are on surfaces. So one rule holds under every technique: **a surface nearer
//! to a light than its clearance ([`LightClearance`](crate::sets::LightClearance)) does not block it.** The clearance is one
//! distance for each light, the same for all casters.
//!
//! Volumes, wedges and the ray caster leave out whole triangles ([`find_grazed`]). That gives the same shadows outside of a
//! closed solid, because a segment that enters it through such a triangle leaves it through another one. Maps put their
//! near plane at the clearance. So behind a surface at a share `s` of the clearance, a map also leaves dark what the light
//! sees through it at less than an angle of asin `s`. An occluder with such a triangle hides nothing from the light.
//!
//! An area light has points on both sides of a surface on which it lies. Techniques that cast from its extent leave out
//! nothing but what is nearer than the clearance to each point. So a light that a surface cuts lights by the part that is
//! outside. Those that cast from its centre treat it as a point.

use glam::{DMat4, DVec3, DVec4, Vec3, Vec4};

use super::caps::extract_caps_without;
use super::contour::{CapMode, Contour, fits};
use super::facing::FacingBits;
use super::planes::{Certainty, FacingPlanes};
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::distance_to_triangle;
use crate::geometry::edge_mesh::EdgeMesh;

/// A light in a caster's space, and its clearance.
#[derive(Clone, Copy, Debug)]
pub struct GrazingLight<'a> {
    /// Position of the light, world space.
    pub light_world: DVec4,
    /// Position of the light in the caster's space.
    pub light_local: Vec4,
    /// The matrix from the caster's space to world space.
    pub world_from_local: &'a DMat4,
    /// Distance from the light within which nothing blocks it, metres.
    pub clearance: f64,
}

impl GrazingLight<'_> {
    /// The world's axes in the caster's space, each as long as the clearance is along it.
    pub(super) fn clearance_axes(&self) -> [Vec3; 3] {
        let local_from_world = self.world_from_local.inverse();
        [DVec3::X, DVec3::Y, DVec3::Z]
            .map(|axis| (local_from_world.transform_vector3(axis) * self.clearance).as_vec3())
    }
}

/// Returns how far the clearance reaches along a plane's normal, in the units of the plane's offset.
pub(super) fn reach_along(axes: &[Vec3; 3], normal: Vec3) -> f32 {
    Vec3::from(axes.map(|axis| normal.dot(axis))).length()
}

/// Finds the triangles that block nothing: those nearer to the light than the clearance, and those whose plane contains
/// the light up to rounding. The result has one word per cluster and one bit per slot, or no words if there are none.
///
/// Cost: the bounds of each cluster, and the triangles of the clusters whose bounds do not exclude the light.
pub fn find_grazed(
    mesh: &EdgeMesh,
    planes: &FacingPlanes,
    positions: &[Vec3],
    light: &GrazingLight,
    words: &mut Vec<u64>,
) {
    /// Relative error within which a plane contains the light: the terms of a facing test have six roundings of 2⁻²⁴,
    /// and the position has as many.
    const ROUNDING: f32 = 12.0 / (1 << 24) as f32;
    words.clear();
    let fits = planes.blocks.len() == mesh.clusters().len() && positions.len() >= mesh.vertex_count();
    if light.light_world.w == 0.0 || !fits {
        return;
    }
    let axes = light.clearance_axes();
    let radius = axes.iter().map(|axis| axis.length_squared()).sum::<f32>().sqrt();
    let at = light.light_local;
    let mut any = false;
    for (index, (cluster, block)) in mesh.clusters().iter().zip(&planes.blocks).enumerate() {
        let is_open = planes
            .bounds
            .get(index)
            .is_none_or(|bounds| bounds.certainty_around(at, radius) == Certainty::Unknown);
        let mut word = 0;
        let corners = &mesh.corners()[cluster.triangles()];
        for (lane, corners) in corners.iter().enumerate().filter(|_| is_open) {
            let normal = Vec3::new(block.x[lane], block.y[lane], block.z[lane]);
            let offset = block.offset[lane];
            let value = (normal.dot(at.truncate()) + offset).abs();
            let holds = value <= ROUNDING * (at.truncate().abs().element_sum() + offset.abs());
            let reach = reach_along(&axes, normal);
            let is_near = || {
                let corners = corners.map(|i| {
                    light
                        .world_from_local
                        .transform_point3(positions[i as usize].as_dvec3())
                });
                distance_to_triangle(light.light_world.truncate(), corners) <= light.clearance
            };
            word |= u64::from(holds || (value <= reach && is_near())) << lane;
        }
        any |= word != 0;
        words.push(word);
    }
    if !any {
        words.clear();
    }
}

/// Whether a slot's bit is set in the words that [`find_grazed`] writes.
pub fn is_grazed(words: &[u64], slot: usize) -> bool {
    let word = words.get(slot / CLUSTER_TRIANGLES);
    word.is_some_and(|word| word >> (slot % CLUSTER_TRIANGLES) & 1 != 0)
}

/// Takes triangles out of a contour of the mesh. Their caps are removed, and their edges become those of the remaining
/// triangles beside them. The contour stays closed.
///
/// Cost: the triangles of the mesh, if any are taken out.
pub fn take_out_of_contour(
    mesh: &EdgeMesh,
    facing: &FacingBits,
    mode: CapMode,
    grazed: &[u64],
    contour: &mut Contour,
) {
    if grazed.is_empty() || !fits(mesh, facing) {
        return;
    }
    let mut edges: Vec<([u32; 2], i32)> = Vec::new();
    each_triangle(mesh, |slot, corners| {
        if is_grazed(grazed, slot) {
            edges.extend(sides(corners).map(|side| (undirected(side).0, 0)));
        }
    });
    edges.sort_unstable();
    edges.dedup();
    let find = |edges: &[([u32; 2], i32)], side| edges.binary_search_by_key(&side, |edge| edge.0);
    contour
        .edges
        .retain(|&edge| find(&edges, undirected(edge).0).is_err());
    contour
        .double_edges
        .retain(|&edge| find(&edges, undirected(edge).0).is_err());
    let closed_slots = mesh.closed_cluster_count() * CLUSTER_TRIANGLES;
    each_triangle(mesh, |slot, corners| {
        let is_open = slot >= closed_slots;
        let weight = match (is_grazed(grazed, slot), facing.is_facing(slot)) {
            (true, _) => 0,
            (false, true) => i32::from(mode != CapMode::ClosedBackFacing || is_open),
            (false, false) => -i32::from(mode != CapMode::ClosedFacing || is_open),
        };
        for (side, sign) in sides(corners).map(undirected) {
            if weight != 0
                && let Ok(at) = find(&edges, side)
            {
                edges[at].1 += weight * sign;
            }
        }
    });
    for ([a, b], multiplicity) in edges {
        let edge = if multiplicity > 0 { [a, b] } else { [b, a] };
        if multiplicity % 2 != 0 {
            contour.edges.push(edge);
        }
        for _ in 0..multiplicity.unsigned_abs() / 2 {
            contour.double_edges.push(edge);
        }
    }
    extract_caps_without(mesh, facing, mode, grazed, contour);
}

pub(super) fn each_triangle(mesh: &EdgeMesh, mut visit: impl FnMut(usize, [u32; 3])) {
    for (index, cluster) in mesh.clusters().iter().enumerate() {
        for (lane, &corners) in mesh.corners()[cluster.triangles()].iter().enumerate() {
            visit(index * CLUSTER_TRIANGLES + lane, corners);
        }
    }
}

pub(super) fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// The edge from its lower vertex to its higher one, and 1, or −1 if it ran the other way.
pub(super) fn undirected([a, b]: [u32; 2]) -> ([u32; 2], i32) {
    if a <= b { ([a, b], 1) } else { ([b, a], -1) }
}
