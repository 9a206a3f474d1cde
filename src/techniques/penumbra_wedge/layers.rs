//! The silhouette in two layers: that of the triangles that face the light, and that of those that do not.
//!
//! A volume of all triangles of an open mesh counts the light twice where it passes a front and a back. A hard shadow
//! does not mind, but coverage would be twice what is covered: so each layer is summed by itself, and the larger sum
//! counts. Where one layer hides what the other hides, as in a mesh that is all but closed, that is exact. Of closed
//! pieces the back-facing triangles are both layers; so are those of all open pieces of a mesh if they agree on facing, as
//! those of a ground.

use glam::Vec3;
use smallvec::SmallVec;

use super::patches::Patches;
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::edge_mesh::{EdgeMesh, LaneSide};
use crate::silhouettes::{CapMode, FacingBits};

/// The layer of triangles that face the light.
pub const FACING: u32 = 1;

/// The layer of triangles that do not.
pub const AVERTED: u32 = 2;

/// What one caster's shadow is made of. Buffers are reused.
#[derive(Clone, Debug, Default)]
pub struct LayeredContour {
    /// Edges in the order of the mesh.
    pub edges: Vec<LayeredEdge>,
    /// Triangles wound towards the light, by layers less 1: facing, averted, both.
    pub caps: [Vec<LayeredCap>; 3],
    /// What edges and caps name; without, all are of patch 0.
    pub patches: Patches,
}

/// An edge that bounds a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayeredEdge {
    /// As the triangles traverse it once they are turned to face the light.
    pub ends: [Vec3; 2],
    /// [`FACING`], [`AVERTED`] or both.
    pub layers: u32,
    /// The patch that it bounds.
    pub patch: u32,
}

/// A triangle of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LayeredCap {
    /// Vertices of the mesh.
    pub corners: [u32; 3],
    /// The patch that it belongs to.
    pub patch: u32,
}

/// Extracts edges and caps of the pose that `facing` was classified for; the order is that of the mesh. `by_patch` tells
/// [patches](super::patches) apart; an edge between a facing and an averted one of an open piece is then there twice.
///
/// Cost: the edges of clusters that are neither all facing nor all averted, all other edges, and the caps; by patches all
/// edges.
pub fn extract_layers(
    mesh: &EdgeMesh,
    positions: &[Vec3],
    facing: &FacingBits,
    mode: CapMode,
    by_patch: bool,
    out: &mut LayeredContour,
) {
    let LayeredContour { edges, caps, patches } = out;
    edges.clear();
    caps.iter_mut().for_each(Vec::clear);
    let words = facing.words();
    if positions.len() < mesh.vertex_count() || words.len() != mesh.clusters().len() {
        return;
    }
    let split = Split::of(mesh, words, mode);
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
        let mut push_unlike = |side: LaneSide, other_slot: usize, other: u64| {
            let is_facing = word >> side.lane() & 1 != 0;
            if is_facing == (other & 1 != 0) {
                return;
            }
            let ends = at(side.vertices(corners), is_facing);
            if !by_patch {
                edges.push(LayeredEdge {
                    ends,
                    layers: FACING | AVERTED,
                    patch: 0,
                });
                return;
            }
            for slot in [first + side.lane(), other_slot] {
                let layers = split.layers_of_slot(mesh, facing, slot);
                if layers != 0 {
                    let patch = patch_of(slot);
                    edges.push(LayeredEdge { ends, layers, patch });
                }
            }
        };
        if word != 0 && word != cluster.full_word() {
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
            let is_facing = word >> (slot % CLUSTER_TRIANGLES) & 1 != 0;
            edges.push(LayeredEdge {
                ends: at(mesh.boundary_vertices()[edge], is_facing),
                layers: split.layers_of(is_facing, false),
                patch: patch_of(slot),
            });
        }
    }
    push_irregular(mesh, facing, split, patch_of, |edge, forward, layers, patch| {
        let ends = at(mesh.irregular_vertices()[edge], forward);
        edges.push(LayeredEdge { ends, layers, patch });
    });
    for (index, (cluster, &word)) in mesh.clusters().iter().zip(words).enumerate() {
        let is_closed = index < mesh.closed_cluster_count();
        for (lane, &[a, b, c]) in mesh.corners()[cluster.triangles()].iter().enumerate() {
            let is_facing = word >> lane & 1 != 0;
            let layers = split.layers_of(is_facing, is_closed);
            if layers != 0 {
                caps[layers as usize - 1].push(LayeredCap {
                    corners: if is_facing { [a, b, c] } else { [a, c, b] },
                    patch: patch_of(index * CLUSTER_TRIANGLES + lane),
                });
            }
        }
    }
}

/// Which triangles are which layer.
#[derive(Clone, Copy)]
struct Split {
    mode: CapMode,
    /// Open pieces have triangles of either kind.
    is_mixed: bool,
}

impl Split {
    fn of(mesh: &EdgeMesh, words: &[u64], mode: CapMode) -> Self {
        let first_open = match mode {
            CapMode::ClosedBackFacing => mesh.closed_cluster_count(),
            CapMode::AllTriangles => 0,
        };
        let open = || mesh.clusters().iter().zip(words).skip(first_open);
        let some_face = open().any(|(_, &word)| word != 0);
        let some_do_not = open().any(|(cluster, &word)| word != cluster.full_word());
        Self {
            mode,
            is_mixed: some_face && some_do_not,
        }
    }

    /// The same of a slot; 0 where a short cluster has no triangle.
    fn layers_of_slot(self, mesh: &EdgeMesh, facing: &FacingBits, slot: usize) -> u32 {
        let cluster = &mesh.clusters()[slot / CLUSTER_TRIANGLES];
        if slot % CLUSTER_TRIANGLES >= cluster.triangle_count as usize {
            return 0;
        }
        let is_closed = slot < mesh.closed_cluster_count() * CLUSTER_TRIANGLES;
        self.layers_of(facing.is_facing(slot), is_closed)
    }

    /// The layers that a triangle belongs to.
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

/// Sums the triangles of each edge that has other than two, patch by patch and layer by layer.
fn push_irregular(
    mesh: &EdgeMesh,
    facing: &FacingBits,
    split: Split,
    patch_of: impl Fn(usize) -> u32,
    mut push: impl FnMut(usize, bool, u32, u32),
) {
    let mut sides: SmallVec<[(u32, u32, i32); 8]> = SmallVec::new();
    for edge in 0..mesh.irregular_vertices().len() {
        sides.clear();
        for side in mesh.irregular_sides(edge) {
            let slot = side.slot() as usize;
            let layers = split.layers_of_slot(mesh, facing, slot);
            if layers != 0 {
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
