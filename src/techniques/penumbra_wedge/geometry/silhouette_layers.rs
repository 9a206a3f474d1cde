//! The silhouette in two layers: that of the triangles that face the light, and that of those that do not.
//!
//! Light that passes a front and a back of an open mesh is counted twice by a volume of all triangles. A hard
//! shadow does not change by that, but coverage would be twice what is covered. So each layer is summed by
//! itself, and the larger sum counts. This is exact where one layer hides what the other hides, as in an
//! almost closed mesh.
//!
//! The back-facing triangles of closed pieces belong to both layers. So do the triangles of all open pieces
//! of a mesh if they all face the same way, as those of a ground.

use glam::Vec3;

pub use super::layer_split::{AVERTED, FACING, Facets, Side};
use super::layer_split::{Split, push_irregular};
use super::patches::Patches;
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::edge_mesh::{EdgeMesh, LaneSide};
use crate::silhouettes::CapMode;

/// Edges and caps of one caster's shadow by layer. Buffers are reused.
#[derive(Clone, Debug, Default)]
pub struct LayeredContour {
    /// Edges in the order of the mesh.
    pub edges: Vec<LayeredEdge>,
    /// Cap triangles, by layers less 1: facing, averted, both.
    pub caps: [Vec<LayeredCap>; 3],
    /// Patches to which the patch numbers of edges and caps refer. Without patches, all numbers are 0.
    pub patches: Patches,
}

/// An edge that bounds a layer, as seen from the light's centre or from elsewhere on the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayeredEdge {
    /// Ends of the edge, in the direction of the triangles once they are turned to face the light's centre.
    pub ends: [Vec3; 2],
    /// Layers that the edge bounds as seen from the centre: [`FACING`], [`AVERTED`], both or none.
    pub layers: u32,
    /// Layers that the edge bounds as seen from some point of the light.
    pub soft_layers: u32,
    /// True if both layers are the averted triangles of a closed piece.
    pub is_closed: bool,
    /// What is beside the edge: on the side that traverses it along `ends`, and on the side that traverses it
    /// the other way.
    pub sides: [Side; 2],
    /// The patch that the edge bounds.
    pub patch: u32,
}

impl LayeredEdge {
    /// Makes an edge that is the same from all points of the light.
    fn fixed(ends: [Vec3; 2], layers: u32, patch: u32) -> Self {
        Self {
            ends,
            layers,
            soft_layers: layers,
            is_closed: false,
            sides: [Side::Facing, Side::Averted],
            patch,
        }
    }
}

/// A cap triangle of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LayeredCap {
    /// Vertex indices of the mesh, in its order, so that the cap is rasterised to exactly the depths of the drawn
    /// surface.
    pub corners: [u32; 3],
    /// True if the triangle is wound towards the light; otherwise it must be turned.
    pub is_facing: bool,
    /// The patch to which the triangle belongs.
    pub patch: u32,
}

/// Extracts edges and caps of the pose for which `facets` were classified, in the order of the mesh.
///
/// With `by_patch`, edges and caps are divided into `patches`. An edge between a facing and an averted patch
/// of an open piece then occurs twice, and no triangle may turn.
///
/// Cost: the edges of clusters that are neither all facing nor all averted, all edges not inside a cluster,
/// and the caps; by patches all edges.
pub fn extract_layers(
    mesh: &EdgeMesh,
    positions: &[Vec3],
    facets: Facets,
    mode: CapMode,
    by_patch: bool,
    out: &mut LayeredContour,
) {
    let LayeredContour { edges, caps, patches } = out;
    edges.clear();
    caps.iter_mut().for_each(Vec::clear);
    let facing = facets.facing;
    let words = facing.words();
    if positions.len() < mesh.vertex_count() || words.len() != mesh.clusters().len() {
        return;
    }
    let split = Split::of(mesh, facets, mode);
    if by_patch {
        patches.find(mesh, facing, |slot| split.layers_of_slot(mesh, facing, slot));
    }
    let patches = by_patch.then_some(&*patches);
    let patch_of = |slot: usize| patches.map_or(0, |patches| patches.of_slot(slot));
    let at = |[a, b]: [u32; 2], forward: bool| {
        let ends = [positions[a as usize], positions[b as usize]];
        if forward { ends } else { [ends[1], ends[0]] }
    };
    for (index, (cluster, &word)) in mesh.clusters().iter().zip(words).enumerate() {
        let corners = &mesh.corners()[cluster.triangles()];
        let first = index * CLUSTER_TRIANGLES;
        let turning = facets.turning_word(index);
        let mut push_unlike = |side: LaneSide, other_slot: usize, other: u64| {
            let slot = first + side.lane();
            let is_facing = word >> side.lane() & 1 != 0;
            if facets.is_grazed(slot) || facets.is_grazed(other_slot) {
                // The edge is now the border of the other triangle.
                let other_facing = other & 1 != 0;
                for (slot, is_facing, forward) in [
                    (slot, is_facing, is_facing),
                    (other_slot, other_facing, !other_facing),
                ] {
                    if facets.is_grazed(slot) {
                        continue;
                    }
                    let layers = split.layers_of_slot(mesh, facing, slot);
                    let ends = at(side.vertices(corners), forward);
                    if facets.turns(slot) {
                        let beside = split.beside(mesh, slot);
                        edges.push(turning_border(ends, slot, is_facing, layers, beside));
                    } else if layers != 0 {
                        edges.push(LayeredEdge::fixed(ends, layers, patch_of(slot)));
                    }
                }
                return;
            }
            let is_unlike = is_facing != (other & 1 != 0);
            let ends = at(side.vertices(corners), is_facing);
            if turning >> side.lane() & 1 != 0 || facets.turns(other_slot) {
                let sides = [facets.side(slot), facets.side(other_slot)];
                edges.push(LayeredEdge {
                    ends,
                    layers: if is_unlike { FACING | AVERTED } else { 0 },
                    soft_layers: FACING | AVERTED,
                    is_closed: split.is_back_only(mesh, slot),
                    sides: if is_facing { sides } else { [sides[1], sides[0]] },
                    patch: 0,
                });
                return;
            }
            if !is_unlike {
                return;
            }
            if !by_patch {
                edges.push(LayeredEdge::fixed(ends, FACING | AVERTED, 0));
                return;
            }
            for slot in [slot, other_slot] {
                let layers = split.layers_of_slot(mesh, facing, slot);
                if layers != 0 {
                    edges.push(LayeredEdge::fixed(ends, layers, patch_of(slot)));
                }
            }
        };
        let is_mixed = word != 0 && word != cluster.full_word();
        if turning != 0 || is_mixed || facets.grazed.get(index).is_some_and(|&word| word != 0) {
            for edge in &mesh.inner_edges()[cluster.inner()] {
                let lane = edge.other_lane % 64;
                push_unlike(edge.side, first + usize::from(lane), word >> lane);
            }
        }
        let sides = mesh.seam_sides()[cluster.seams()].iter();
        for (&side, &slot) in sides.zip(&mesh.seam_slots()[cluster.seams()]) {
            let slot = slot as usize;
            let other = words[slot / CLUSTER_TRIANGLES] >> (slot % CLUSTER_TRIANGLES);
            push_unlike(side, slot, other);
        }
    }
    for (cluster, &word) in mesh
        .clusters()
        .iter()
        .zip(words)
        .skip(mesh.closed_cluster_count())
    {
        for edge in cluster.boundary() {
            let slot = mesh.boundary_slots()[edge] as usize;
            if facets.is_grazed(slot) {
                continue;
            }
            let is_facing = word >> (slot % CLUSTER_TRIANGLES) & 1 != 0;
            let ends = at(mesh.boundary_vertices()[edge], is_facing);
            let layers = split.layers_of(is_facing, false);
            edges.push(if facets.turns(slot) {
                turning_border(ends, slot, is_facing, layers, Side::Open)
            } else {
                LayeredEdge::fixed(ends, layers, patch_of(slot))
            });
        }
    }
    push_irregular(mesh, facets, split, patch_of, |edge, forward, layers, patch| {
        let ends = at(mesh.irregular_vertices()[edge], forward);
        edges.push(LayeredEdge::fixed(ends, layers, patch));
    });
    for edge in 0..mesh.irregular_vertices().len() {
        for side in mesh.irregular_sides(edge) {
            let slot = side.slot() as usize;
            if facets.turns(slot) {
                let is_facing = facing.is_facing(slot);
                let ends = at(mesh.irregular_vertices()[edge], is_facing != side.is_reversed());
                let layers = split.layers_of_slot(mesh, facing, slot);
                edges.push(turning_border(
                    ends,
                    slot,
                    is_facing,
                    layers,
                    split.beside(mesh, slot),
                ));
            }
        }
    }
    for (index, (cluster, &word)) in mesh.clusters().iter().zip(words).enumerate() {
        let is_closed = index < mesh.closed_cluster_count();
        for (lane, &[a, b, c]) in mesh.corners()[cluster.triangles()].iter().enumerate() {
            let is_facing = word >> lane & 1 != 0;
            let layers = split.layers_of(is_facing, is_closed);
            if layers != 0 && !facets.is_grazed(index * CLUSTER_TRIANGLES + lane) {
                caps[layers as usize - 1].push(LayeredCap {
                    corners: [a, b, c],
                    is_facing,
                    patch: patch_of(index * CLUSTER_TRIANGLES + lane),
                });
            }
        }
    }
}

/// Makes an edge that bounds a turning triangle alone; `other` stands for the other side. `ends` are in the
/// direction of the triangle once it is turned to face the light's centre.
fn turning_border(ends: [Vec3; 2], slot: usize, is_facing: bool, layers: u32, other: Side) -> LayeredEdge {
    let sides = [Side::Turning(slot as u32), other];
    LayeredEdge {
        ends,
        layers,
        soft_layers: FACING | AVERTED,
        is_closed: other == Side::Facing,
        sides: if is_facing { sides } else { [sides[1], sides[0]] },
        patch: 0,
    }
}
