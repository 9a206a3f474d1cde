//! Which layer a triangle belongs to, and the edges that do not have exactly two triangles.

use smallvec::SmallVec;

use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::edge_mesh::EdgeMesh;
use crate::silhouettes::grazed::is_grazed;
use crate::silhouettes::{CapMode, FacingBits};

/// The layer of triangles that face the light.
pub const FACING: u32 = 1;

/// The layer of triangles that do not face the light.
pub const AVERTED: u32 = 2;

/// The neighbour on one side of an edge.
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
    /// Triangles among the grazed whose plane contains the light's centre, and which lie beyond the light's extent: they
    /// have penumbra edges, but no hard shadow. One word per cluster, or no words if there are none.
    pub level: &'a [u64],
}

impl Facets<'_> {
    pub(super) fn turns(&self, slot: usize) -> bool {
        let word = self.turning.get(slot / CLUSTER_TRIANGLES);
        word.is_some_and(|word| word >> (slot % CLUSTER_TRIANGLES) & 1 != 0)
    }

    pub(super) fn is_grazed(&self, slot: usize) -> bool {
        is_grazed(self.grazed, slot)
    }

    /// Returns whether a triangle has penumbra edges without hard shadow.
    pub(super) fn is_level(&self, slot: usize) -> bool {
        is_grazed(self.level, slot)
    }

    pub(super) fn turning_word(&self, cluster: usize) -> u64 {
        self.turning.get(cluster).copied().unwrap_or(0)
    }

    pub(super) fn side(&self, slot: usize) -> Side {
        match (self.turns(slot), self.facing.is_facing(slot)) {
            (true, _) => Side::Turning(slot as u32),
            (false, true) => Side::Facing,
            (false, false) => Side::Averted,
        }
    }
}

/// Assigns triangles to layers.
#[derive(Clone, Copy)]
pub(super) struct Split {
    mode: CapMode,
    /// Whether open pieces have both facing and averted triangles.
    is_mixed: bool,
}

impl Split {
    pub(super) fn of(mesh: &EdgeMesh, facets: Facets, mode: CapMode) -> Self {
        let words = facets.facing.words();
        let first_open = match mode {
            CapMode::ClosedBackFacing | CapMode::ClosedFacing => mesh.closed_cluster_count(),
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

    /// Returns the neighbour that is assumed at an edge where a triangle is considered alone. In a closed piece that counts
    /// only its averted triangles it is one that faces the light, and in one that counts only its facing triangles it is one
    /// that is averted. Such a neighbour does not count. Other pieces have no neighbour there.
    pub(super) fn beside(self, mesh: &EdgeMesh, slot: usize) -> Side {
        match (self.counts_one_kind(mesh, slot), self.mode) {
            (false, _) => Side::Open,
            (true, CapMode::ClosedFacing) => Side::Averted,
            (true, _) => Side::Facing,
        }
    }

    /// Whether only one kind of triangles counts in the piece of the triangle in a slot: the averted or the facing ones.
    pub(super) fn counts_one_kind(self, mesh: &EdgeMesh, slot: usize) -> bool {
        self.mode != CapMode::AllTriangles && slot < mesh.closed_cluster_count() * CLUSTER_TRIANGLES
    }

    /// Returns the layers of the triangle in a slot; 0 where a short cluster has no triangle.
    pub(super) fn layers_of_slot(self, mesh: &EdgeMesh, facing: &FacingBits, slot: usize) -> u32 {
        let cluster = &mesh.clusters()[slot / CLUSTER_TRIANGLES];
        if slot % CLUSTER_TRIANGLES >= cluster.triangle_count as usize {
            return 0;
        }
        let is_closed = slot < mesh.closed_cluster_count() * CLUSTER_TRIANGLES;
        self.layers_of(facing.is_facing(slot), is_closed)
    }

    /// Returns the layers to which a triangle belongs.
    pub(super) fn layers_of(self, is_facing: bool, is_closed: bool) -> u32 {
        let counts_alone = match self.mode {
            CapMode::AllTriangles => None,
            CapMode::ClosedBackFacing => Some(!is_facing),
            CapMode::ClosedFacing => Some(is_facing),
        };
        match (counts_alone.filter(|_| is_closed), is_facing) {
            (Some(false), _) => 0,
            (Some(true), _) => FACING | AVERTED,
            (None, _) if !self.is_mixed => FACING | AVERTED,
            (None, true) => FACING,
            (None, false) => AVERTED,
        }
    }
}

/// Sums the triangles of each edge that does not have exactly two, by patch and by layer. Turning triangles
/// are left out.
pub(super) fn push_irregular(
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
