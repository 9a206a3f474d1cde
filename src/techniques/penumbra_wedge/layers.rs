//! The silhouette in two layers: that of the triangles that face the light, and that of those that do not.
//!
//! A volume of all triangles of an open mesh counts the light twice where it passes a front and a back. A hard shadow
//! does not mind, but coverage would be twice what is covered: so each layer is summed by itself, and the larger sum
//! counts. Where one layer hides what the other hides, as in a mesh that is all but closed, that is exact. Of closed
//! pieces the back-facing triangles are both layers; so are those of all open pieces of a mesh if they agree on facing, as
//! those of a ground.

use glam::Vec3;

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
    /// Edges as the triangles traverse them once they are turned to face the light, and their layers.
    pub edges: Vec<([Vec3; 2], u32)>,
    /// Triangles wound towards the light, by layers less 1: facing, averted, both.
    pub caps: [Vec<[u32; 3]>; 3],
}

/// Extracts edges and caps of the pose that `facing` was classified for; the order is that of the mesh.
///
/// Cost: the edges of clusters that are neither all facing nor all averted, all other edges, and the caps.
pub fn extract_layers(
    mesh: &EdgeMesh,
    positions: &[Vec3],
    facing: &FacingBits,
    mode: CapMode,
    out: &mut LayeredContour,
) {
    out.edges.clear();
    out.caps.iter_mut().for_each(Vec::clear);
    let words = facing.words();
    if positions.len() < mesh.vertex_count() || words.len() != mesh.clusters().len() {
        return;
    }
    let split = Split::of(mesh, words, mode);
    let at = |[a, b]: [u32; 2], forward: bool| {
        let ends = [positions[a as usize], positions[b as usize]];
        if forward { ends } else { [ends[1], ends[0]] }
    };
    for (cluster, &word) in mesh.clusters().iter().zip(words) {
        let corners = &mesh.corners()[cluster.triangles()];
        let mut push_unlike = |side: LaneSide, other: u64| {
            let is_facing = word >> side.lane() & 1 != 0;
            if is_facing != (other & 1 != 0) {
                let ends = at(side.vertices(corners), is_facing);
                out.edges.push((ends, FACING | AVERTED));
            }
        };
        if word != 0 && word != cluster.full_word() {
            for edge in &mesh.inner_edges()[cluster.inner()] {
                push_unlike(edge.side, word >> (edge.other_lane % 64));
            }
        }
        let sides = mesh.seam_sides()[cluster.seams()].iter();
        for (&side, &slot) in sides.zip(&mesh.seam_slots()[cluster.seams()]) {
            let slot = slot as usize;
            push_unlike(
                side,
                words[slot / CLUSTER_TRIANGLES] >> (slot % CLUSTER_TRIANGLES),
            );
        }
    }
    for (cluster, &word) in mesh
        .clusters()
        .iter()
        .zip(words)
        .skip(mesh.closed_cluster_count())
    {
        for edge in cluster.boundary() {
            let lane = mesh.boundary_slots()[edge] as usize % CLUSTER_TRIANGLES;
            let is_facing = word >> lane & 1 != 0;
            let ends = at(mesh.boundary_vertices()[edge], is_facing);
            out.edges.push((ends, split.layers_of(is_facing, false)));
        }
    }
    push_irregular(mesh, facing, split, |edge, forward, layers| {
        out.edges
            .push((at(mesh.irregular_vertices()[edge], forward), layers));
    });
    for (index, (cluster, &word)) in mesh.clusters().iter().zip(words).enumerate() {
        let is_closed = index < mesh.closed_cluster_count();
        for (lane, &[a, b, c]) in mesh.corners()[cluster.triangles()].iter().enumerate() {
            let is_facing = word >> lane & 1 != 0;
            let layers = split.layers_of(is_facing, is_closed);
            if layers != 0 {
                let turned = if is_facing { [a, b, c] } else { [a, c, b] };
                out.caps[layers as usize - 1].push(turned);
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

/// Sums the triangles of each edge that has other than two, layer by layer.
fn push_irregular(
    mesh: &EdgeMesh,
    facing: &FacingBits,
    split: Split,
    mut push: impl FnMut(usize, bool, u32),
) {
    let closed_slots = mesh.closed_cluster_count() * CLUSTER_TRIANGLES;
    for edge in 0..mesh.irregular_vertices().len() {
        let mut sums = [0i32; 2];
        for side in mesh.irregular_sides(edge) {
            let slot = side.slot() as usize;
            let is_facing = facing.is_facing(slot);
            let layers = split.layers_of(is_facing, slot < closed_slots);
            let sign = if is_facing == side.is_reversed() { -1 } else { 1 };
            for (layer, sum) in sums.iter_mut().enumerate() {
                if layers >> layer & 1 != 0 {
                    *sum += sign;
                }
            }
        }
        for forward in [true, false] {
            let [mut f, mut b] = sums.map(|sum| if forward { sum.max(0) } else { (-sum).max(0) });
            while f > 0 || b > 0 {
                let layers = u32::from(f > 0) * FACING + u32::from(b > 0) * AVERTED;
                push(edge, forward, layers);
                (f, b) = (f - 1, b - 1);
            }
        }
    }
}
