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
    if positions.len() < mesh.vertex_count() || facing.words().len() != mesh.clusters().len() {
        return;
    }
    let split = Split::of(mesh, facets, mode);
    if by_patch {
        patches.find(mesh, facing, |slot| split.layers_of_slot(mesh, facing, slot));
    }
    let mut extraction = Extraction {
        mesh,
        positions,
        facets,
        split,
        patches: by_patch.then_some(&*patches),
        edges,
    };
    extraction.push_shared_edges();
    extraction.push_borders();
    extraction.push_irregular_edges();
    extraction.push_caps(caps);
}

/// The extraction of one caster's edges.
struct Extraction<'a> {
    mesh: &'a EdgeMesh,
    positions: &'a [Vec3],
    facets: Facets<'a>,
    split: Split,
    patches: Option<&'a Patches>,
    edges: &'a mut Vec<LayeredEdge>,
}

impl Extraction<'_> {
    fn patch_of(&self, slot: usize) -> u32 {
        patch_of(self.patches, slot)
    }

    fn ends(&self, vertices: [u32; 2], forward: bool) -> [Vec3; 2] {
        ends(self.positions, vertices, forward)
    }

    fn layers_of_slot(&self, slot: usize) -> u32 {
        self.split.layers_of_slot(self.mesh, self.facets.facing, slot)
    }

    /// Pushes an edge that is the same from all points of the light, if it bounds a layer.
    fn push_fixed(&mut self, ends: [Vec3; 2], layers: u32, slot: usize) {
        if layers != 0 {
            self.edges
                .push(LayeredEdge::fixed(ends, layers, self.patch_of(slot)));
        }
    }

    /// Pushes the edges between two triangles: those inside of a cluster, and those between clusters.
    fn push_shared_edges(&mut self) {
        let (mesh, words) = (self.mesh, self.facets.facing.words());
        for (index, (cluster, &word)) in mesh.clusters().iter().zip(words).enumerate() {
            let corners = &mesh.corners()[cluster.triangles()];
            let first = index * CLUSTER_TRIANGLES;
            let is_mixed = word != 0 && word != cluster.full_word();
            let is_grazed = self.facets.grazed.get(index).is_some_and(|&word| word != 0);
            if self.facets.turning_word(index) != 0 || is_mixed || is_grazed {
                for edge in &mesh.inner_edges()[cluster.inner()] {
                    let other_slot = first + usize::from(edge.other_lane % 64);
                    self.push_between(corners, edge.side, first, other_slot);
                }
            }
            let sides = mesh.seam_sides()[cluster.seams()].iter();
            for (&side, &slot) in sides.zip(&mesh.seam_slots()[cluster.seams()]) {
                self.push_between(corners, side, first, slot as usize);
            }
        }
    }

    /// Pushes the edge between a triangle of the cluster that begins at the slot `first`, and another triangle.
    fn push_between(&mut self, corners: &[[u32; 3]], side: LaneSide, first: usize, other_slot: usize) {
        let facets = self.facets;
        let slot = first + side.lane();
        let is_facing = facets.facing.is_facing(slot);
        let is_unlike = is_facing != facets.facing.is_facing(other_slot);
        let vertices = side.vertices(corners);
        if facets.is_grazed(slot) || facets.is_grazed(other_slot) {
            self.push_beside_grazed(vertices, slot, other_slot);
        } else if facets.turns(slot) || facets.turns(other_slot) {
            let sides = [facets.side(slot), facets.side(other_slot)];
            self.edges.push(LayeredEdge {
                ends: self.ends(vertices, is_facing),
                layers: if is_unlike { FACING | AVERTED } else { 0 },
                soft_layers: FACING | AVERTED,
                is_closed: self.split.counts_one_kind(self.mesh, slot),
                sides: if is_facing { sides } else { [sides[1], sides[0]] },
                patch: 0,
            });
        } else if is_unlike && self.patches.is_none() {
            self.push_fixed(self.ends(vertices, is_facing), FACING | AVERTED, slot);
        } else if is_unlike {
            for slot in [slot, other_slot] {
                let layers = self.layers_of_slot(slot);
                self.push_fixed(self.ends(vertices, is_facing), layers, slot);
            }
        }
    }

    /// Pushes an edge of which one triangle blocks nothing: it is the border of the other.
    fn push_beside_grazed(&mut self, vertices: [u32; 2], slot: usize, other_slot: usize) {
        let facets = self.facets;
        let [is_facing, other_facing] = [slot, other_slot].map(|slot| facets.facing.is_facing(slot));
        // Between two level triangles, the edge is inside of their plane.
        let is_inside = facets.is_level(slot) && facets.is_level(other_slot);
        for (slot, is_facing, forward) in [
            (slot, is_facing, is_facing),
            (other_slot, other_facing, !other_facing),
        ] {
            if facets.is_grazed(slot) {
                if facets.is_level(slot) && !is_inside {
                    self.edges
                        .push(level_border(self.ends(vertices, forward), slot, is_facing));
                }
                continue;
            }
            let layers = self.layers_of_slot(slot);
            let ends = self.ends(vertices, forward);
            if facets.turns(slot) {
                let beside = self.split.beside(self.mesh, slot);
                self.edges
                    .push(turning_border(ends, slot, is_facing, layers, beside));
            } else {
                self.push_fixed(ends, layers, slot);
            }
        }
    }

    /// Pushes the edges that only one triangle has.
    fn push_borders(&mut self) {
        let mesh = self.mesh;
        for cluster in mesh.clusters().iter().skip(mesh.closed_cluster_count()) {
            for edge in cluster.boundary() {
                let slot = mesh.boundary_slots()[edge] as usize;
                let is_facing = self.facets.facing.is_facing(slot);
                let ends = self.ends(mesh.boundary_vertices()[edge], is_facing);
                if self.facets.is_level(slot) {
                    self.edges.push(level_border(ends, slot, is_facing));
                }
                if self.facets.is_grazed(slot) {
                    continue;
                }
                let layers = self.split.layers_of(is_facing, false);
                self.edges.push(if self.facets.turns(slot) {
                    turning_border(ends, slot, is_facing, layers, Side::Open)
                } else {
                    LayeredEdge::fixed(ends, layers, self.patch_of(slot))
                });
            }
        }
    }

    /// Pushes the edges of three or more triangles: first as they are from the centre, then those of triangles that turn.
    fn push_irregular_edges(&mut self) {
        let Self {
            mesh,
            positions,
            facets,
            split,
            patches,
            ref mut edges,
        } = *self;
        let patch_of = |slot| patch_of(patches, slot);
        push_irregular(mesh, facets, split, patch_of, |edge, forward, layers, patch| {
            let ends = ends(positions, mesh.irregular_vertices()[edge], forward);
            edges.push(LayeredEdge::fixed(ends, layers, patch));
        });
        for edge in 0..mesh.irregular_vertices().len() {
            for side in mesh.irregular_sides(edge) {
                let slot = side.slot() as usize;
                let is_facing = facets.facing.is_facing(slot);
                let ends = self.ends(mesh.irregular_vertices()[edge], is_facing != side.is_reversed());
                if facets.is_level(slot) {
                    self.edges.push(level_border(ends, slot, is_facing));
                }
                if facets.turns(slot) {
                    let layers = self.layers_of_slot(slot);
                    let beside = split.beside(mesh, slot);
                    self.edges
                        .push(turning_border(ends, slot, is_facing, layers, beside));
                }
            }
        }
    }

    /// Pushes the triangles of each layer.
    fn push_caps(&self, caps: &mut [Vec<LayeredCap>; 3]) {
        let (mesh, words) = (self.mesh, self.facets.facing.words());
        for (index, (cluster, &word)) in mesh.clusters().iter().zip(words).enumerate() {
            let is_closed = index < mesh.closed_cluster_count();
            for (lane, &corners) in mesh.corners()[cluster.triangles()].iter().enumerate() {
                let is_facing = word >> lane & 1 != 0;
                let slot = index * CLUSTER_TRIANGLES + lane;
                let layers = self.split.layers_of(is_facing, is_closed);
                if layers != 0 && !self.facets.is_grazed(slot) {
                    caps[layers as usize - 1].push(LayeredCap {
                        corners,
                        is_facing,
                        patch: self.patch_of(slot),
                    });
                }
            }
        }
    }
}

/// Returns the patch of a triangle; 0 without patches.
fn patch_of(patches: Option<&Patches>, slot: usize) -> u32 {
    patches.map_or(0, |patches| patches.of_slot(slot))
}

/// Returns the ends of an edge in the direction of its vertices, or in the other direction.
fn ends(positions: &[Vec3], [a, b]: [u32; 2], forward: bool) -> [Vec3; 2] {
    let ends = [positions[a as usize], positions[b as usize]];
    if forward { ends } else { [ends[1], ends[0]] }
}

/// Makes an edge that bounds a turning triangle alone; `other` stands for the other side. `ends` are in the
/// direction of the triangle once it is turned to face the light's centre.
fn turning_border(ends: [Vec3; 2], slot: usize, is_facing: bool, layers: u32, other: Side) -> LayeredEdge {
    let sides = [Side::Turning(slot as u32), other];
    LayeredEdge {
        ends,
        layers,
        soft_layers: FACING | AVERTED,
        is_closed: other != Side::Open,
        sides: if is_facing { sides } else { [sides[1], sides[0]] },
        patch: 0,
    }
}

/// Makes an edge that bounds a level triangle alone, and no hard shadow. `ends` are in the direction of the triangle once it is
/// turned to face the light's centre, as its facing bit has it; either direction gives the same sums.
fn level_border(ends: [Vec3; 2], slot: usize, is_facing: bool) -> LayeredEdge {
    turning_border(ends, slot, is_facing, 0, Side::Open)
}
