//! One bit per triangle: whether its front is towards the light.

use glam::Vec4;
use wide::f32x8;

use super::planes::{Certainty, FacingPlanes, PlaneBlock};
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::edge_mesh::EdgeMesh;

/// Which triangles face a light: one word per cluster, one bit per slot.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FacingBits {
    words: Vec<u64>,
    /// [`HAS_BACK`] and [`HAS_FACING`] of each cluster. A byte each, because seams read them in random order
    /// and all of them should stay in the first-level cache.
    states: Vec<u8>,
    /// Clusters whose bounds did not decide.
    tested: Vec<u32>,
}

/// The cluster has a triangle that does not face the light.
pub(super) const HAS_BACK: u8 = 1;
/// The cluster has a triangle that faces the light.
pub(super) const HAS_FACING: u8 = 2;
/// The cluster has triangles of both kinds.
pub(super) const MIXED: u8 = HAS_BACK | HAS_FACING;

impl FacingBits {
    /// One word per cluster; bits beyond the cluster's triangles are 0.
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    pub(super) fn states(&self) -> &[u8] {
        &self.states
    }

    /// Whether the triangle in `slot` faces the light.
    pub fn is_facing(&self, slot: usize) -> bool {
        self.words[slot / CLUSTER_TRIANGLES] >> (slot % CLUSTER_TRIANGLES) & 1 != 0
    }

    /// Clusters with triangles of both kinds.
    pub fn mixed_cluster_count(&self) -> usize {
        self.states.iter().filter(|&&state| state == MIXED).count()
    }

    /// Takes bits chosen by the caller, one word per cluster of `mesh`. The contour is closed for any choice.
    pub fn from_words(mesh: &EdgeMesh, words: impl IntoIterator<Item = u64>) -> Self {
        let mut bits = Self::default();
        for (cluster, word) in mesh.clusters().iter().zip(words) {
            bits.push(word & cluster.full_word(), cluster.full_word());
        }
        bits
    }

    fn clear(&mut self) {
        self.words.clear();
        self.states.clear();
        self.tested.clear();
    }

    fn push(&mut self, word: u64, full_word: u64) {
        self.words.push(word);
        self.states.push(state_of(word, full_word));
    }
}

/// Decides for each triangle whether the light lies strictly in front of its plane.
///
/// A light on the plane counts as not facing, and so does NaN. `light_local` is a position with `w = 1` or,
/// with `w = 0`, the direction towards the light. If `planes` are not those of `mesh`, there are no bits and
/// nothing is cast.
///
/// The contour is closed for any answer, so rounding can only change triangles that are edge-on to the light.
///
/// Cost: each cluster's bounds, and the triangles of clusters whose bounds do not decide. The bits equal
/// those of [`classify_scalar`] exactly. Idea of culling by bounds: The Dark Mod; ours uses normal cones.
pub fn classify(mesh: &EdgeMesh, planes: &FacingPlanes, light_local: Vec4, bits: &mut FacingBits) {
    bits.clear();
    if planes.blocks.len() != mesh.clusters().len() {
        return;
    }
    bits.words.reserve(planes.blocks.len());
    bits.states.reserve(planes.blocks.len());
    if planes.bounds.is_empty() {
        bits.tested.extend(0..planes.blocks.len() as u32);
        for (cluster, block) in mesh.clusters().iter().zip(&planes.blocks) {
            bits.push(facing_word(block, light_local), cluster.full_word());
        }
        return;
    }
    // All bounds are tested before the first plane is read. With both in one loop, each mispredicted branch
    // delayed the load of the next block's planes, which are far away in memory (0.4 ns a triangle, interior
    // by mesh).
    bits.tested.resize(planes.bounds.len(), 0);
    let mut tested = 0;
    for (i, (cluster, bounds)) in mesh.clusters().iter().zip(&planes.bounds).enumerate() {
        let certainty = bounds.certainty(light_local);
        let full_word = cluster.full_word();
        bits.push(
            if certainty == Certainty::AllFacing {
                full_word
            } else {
                0
            },
            full_word,
        );
        bits.tested[tested] = i as u32;
        tested += usize::from(certainty == Certainty::Unknown);
    }
    bits.tested.truncate(tested);
    for &i in &bits.tested {
        let i = i as usize;
        let word = facing_word(&planes.blocks[i], light_local);
        bits.words[i] = word;
        bits.states[i] = state_of(word, mesh.clusters()[i].full_word());
    }
}

fn state_of(word: u64, full_word: u64) -> u8 {
    (u8::from(word != 0) * HAS_FACING) | (u8::from(word != full_word) * HAS_BACK)
}

/// Scalar twin of [`classify`]: tests every triangle, one at a time.
pub fn classify_scalar(mesh: &EdgeMesh, planes: &FacingPlanes, light_local: Vec4, bits: &mut FacingBits) {
    bits.clear();
    if planes.blocks.len() != mesh.clusters().len() {
        return;
    }
    let l = light_local;
    for (cluster, block) in mesh.clusters().iter().zip(&planes.blocks) {
        let mut word = 0;
        for lane in 0..cluster.triangle_count as usize {
            // The terms are added in the order of `facing_word`.
            let value =
                block.x[lane] * l.x + block.y[lane] * l.y + block.z[lane] * l.z + block.offset[lane] * l.w;
            word |= u64::from(value > 0.0) << lane;
        }
        bits.push(word, cluster.full_word());
    }
    bits.tested.extend(0..planes.blocks.len() as u32);
}

/// Tests the planes of one block. It uses no fused multiply-add, so the bits are the same on every machine
/// and equal to those of [`classify_scalar`].
fn facing_word(block: &PlaneBlock, light_local: Vec4) -> u64 {
    let [x, y, z, w] = light_local.to_array().map(f32x8::splat);
    let (xs, ys) = (block.x.as_chunks::<8>().0, block.y.as_chunks::<8>().0);
    let (zs, offsets) = (block.z.as_chunks::<8>().0, block.offset.as_chunks::<8>().0);
    let mut word = 0;
    for i in 0..CLUSTER_TRIANGLES / 8 {
        let value = f32x8::new(xs[i]) * x
            + f32x8::new(ys[i]) * y
            + f32x8::new(zs[i]) * z
            + f32x8::new(offsets[i]) * w;
        let byte = value.simd_gt(f32x8::ZERO).to_bitmask();
        word |= u64::from(byte) << (i * 8);
    }
    word
}
