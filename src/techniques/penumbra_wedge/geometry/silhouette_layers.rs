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
use smallvec::SmallVec;

use super::patches::Patches;
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::edge_mesh::{EdgeMesh, LaneSide};
use crate::silhouettes::grazed::is_grazed;
use crate::silhouettes::{CapMode, FacingBits};

/// The layer of triangles that face the light.
pub const FACING: u32 = 1;

/// The layer of triangles that do not face the light.
pub const AVERTED: u32 = 2;

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

/// What is on one side of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// A triangle that faces all points of the light.
    Facing,
    /// A triangle that faces no point of the light.
    Averted,
    /// No triangle.
    Open,
    /// The triangle of a slot whose plane cuts the light, so it faces a part of the light only.
    Turning(u32),
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

/// Which triangles face the light's centre, and which face a part of the light only.
#[derive(Clone, Copy)]
pub struct Facets<'a> {
    /// Triangles that face the centre.
    pub facing: &'a FacingBits,
    /// Triangles whose planes cut the light, one word per cluster. Empty for a silhouette from the centre
    /// alone.
    pub turning: &'a [u64],
    /// Triangles that block nothing; none of them turns. One word per cluster, or no words if there are none.
    pub grazed: &'a [u64],
}

impl Facets<'_> {
    fn turns(&self, slot: usize) -> bool {
        let word = self.turning.get(slot / CLUSTER_TRIANGLES);
        word.is_some_and(|word| word >> (slot % CLUSTER_TRIANGLES) & 1 != 0)
    }

    fn is_grazed(&self, slot: usize) -> bool {
        is_grazed(self.grazed, slot)
    }

    fn turning_word(&self, cluster: usize) -> u64 {
        self.turning.get(cluster).copied().unwrap_or(0)
    }

    fn side(&self, slot: usize) -> Side {
        match (self.turns(slot), self.facing.is_facing(slot)) {
            (true, _) => Side::Turning(slot as u32),
            (false, true) => Side::Facing,
            (false, false) => Side::Averted,
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

/// Assigns triangles to layers.
#[derive(Clone, Copy)]
struct Split {
    mode: CapMode,
    /// Whether open pieces have both facing and averted triangles.
    is_mixed: bool,
}

impl Split {
    fn of(mesh: &EdgeMesh, facets: Facets, mode: CapMode) -> Self {
        let words = facets.facing.words();
        let first_open = match mode {
            CapMode::ClosedBackFacing => mesh.closed_cluster_count(),
            CapMode::AllTriangles => 0,
        };
        let open = || mesh.clusters().iter().zip(words).skip(first_open);
        let some_turn = facets.turning.iter().skip(first_open).any(|&word| word != 0);
        let some_face = open().any(|(_, &word)| word != 0);
        let some_do_not = open().any(|(cluster, &word)| word != cluster.full_word());
        Self {
            mode,
            is_mixed: some_turn || (some_face && some_do_not),
        }
    }

    /// What stands beside a triangle that is considered alone. Closed pieces count only their averted
    /// triangles. Those are all triangles less the facing ones, so the triangle is paired with one that
    /// faces.
    fn beside(self, mesh: &EdgeMesh, slot: usize) -> Side {
        if self.is_back_only(mesh, slot) {
            Side::Facing
        } else {
            Side::Open
        }
    }

    fn is_back_only(self, mesh: &EdgeMesh, slot: usize) -> bool {
        self.mode == CapMode::ClosedBackFacing && slot < mesh.closed_cluster_count() * CLUSTER_TRIANGLES
    }

    /// Returns the layers of the triangle in a slot; 0 where a short cluster has no triangle.
    fn layers_of_slot(self, mesh: &EdgeMesh, facing: &FacingBits, slot: usize) -> u32 {
        let cluster = &mesh.clusters()[slot / CLUSTER_TRIANGLES];
        if slot % CLUSTER_TRIANGLES >= cluster.triangle_count as usize {
            return 0;
        }
        let is_closed = slot < mesh.closed_cluster_count() * CLUSTER_TRIANGLES;
        self.layers_of(facing.is_facing(slot), is_closed)
    }

    /// Returns the layers to which a triangle belongs.
    fn layers_of(self, is_facing: bool, is_closed: bool) -> u32 {
        match (is_closed && self.mode == CapMode::ClosedBackFacing, is_facing) {
            (true, true) => 0,
            (true, false) => FACING | AVERTED,
            (false, _) if !self.is_mixed => FACING | AVERTED,
            (false, true) => FACING,
            (false, false) => AVERTED,
        }
    }
}

/// Sums the triangles of each edge that does not have exactly two, by patch and by layer. Turning triangles
/// are left out.
fn push_irregular(
    mesh: &EdgeMesh,
    facets: Facets,
    split: Split,
    patch_of: impl Fn(usize) -> u32,
    mut push: impl FnMut(usize, bool, u32, u32),
) {
    let facing = facets.facing;
    let mut sides: SmallVec<[(u32, u32, i32); 8]> = SmallVec::new();
    for edge in 0..mesh.irregular_vertices().len() {
        sides.clear();
        for side in mesh.irregular_sides(edge) {
            let slot = side.slot() as usize;
            let layers = split.layers_of_slot(mesh, facing, slot);
            if layers != 0 && !facets.turns(slot) && !facets.is_grazed(slot) {
                let sign = if facing.is_facing(slot) == side.is_reversed() {
                    -1
                } else {
                    1
                };
                sides.push((patch_of(slot), layers, sign));
            }
        }
        sides.sort_unstable();
        for of_patch in sides.chunk_by(|a, b| a.0 == b.0) {
            let sum = |layer: u32| -> i32 {
                let in_layer = of_patch.iter().filter(|side| side.1 & layer != 0);
                in_layer.map(|side| side.2).sum()
            };
            let sums = [sum(FACING), sum(AVERTED)];
            for forward in [true, false] {
                let [mut f, mut b] = sums.map(|sum| if forward { sum.max(0) } else { (-sum).max(0) });
                while f > 0 || b > 0 {
                    let layers = u32::from(f > 0) * FACING + u32::from(b > 0) * AVERTED;
                    push(edge, forward, layers, of_patch[0].0);
                    (f, b) = (f - 1, b - 1);
                }
            }
        }
    }
}
