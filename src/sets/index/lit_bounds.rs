//! Bounds of many boxes at once: those of a set, each cut by a box.

use fixedbitset::FixedBitSet;
use wide::f32x8;

use super::box_tests::splat;
use super::boxes::{Boxes, Group, LANES, lane_mask};
use super::clusters::Clusters;
use super::word_bounds::reduce;
use crate::geometry::Aabb;

/// The box around the parts of a set's boxes that lie in `cut`. `words` must have a bit for every word of the
/// set that is not 0.
pub(in crate::sets) fn lit_bounds(
    boxes: &Boxes,
    clusters: &Clusters,
    words: &FixedBitSet,
    set: impl Fn(usize) -> usize,
    cut: &Aabb,
) -> Aabb {
    let mut lit = Aabb::EMPTY;
    for word in words.ones() {
        let bits = set(word);
        // Whatever the word could add is already inside.
        if bits == 0 || contains(&lit, &clusters.words.get(word).intersection(*cut)) {
            continue;
        }
        lit = lit.union(cut_bounds(boxes.word(word), bits, cut));
    }
    lit
}

fn contains(outer: &Aabb, inner: &Aabb) -> bool {
    outer.min.cmple(inner.min).all() && inner.max.cmple(outer.max).all()
}

/// The box around those parts of a word's boxes that lie in `cut`.
fn cut_bounds(groups: &[Group], bits: usize, cut: &Aabb) -> Aabb {
    let (cut_min, cut_max) = (splat(cut.min), splat(cut.max));
    let mut min = [f32x8::splat(f32::INFINITY); 3];
    let mut max = [f32x8::splat(f32::NEG_INFINITY); 3];
    for (at, group) in groups.iter().enumerate() {
        let lanes = bits >> (at * LANES) & 0xff;
        if lanes == 0 {
            continue;
        }
        let low = [0, 1, 2].map(|i| (group.center[i] - group.half[i]).fast_max(cut_min[i]));
        let high = [0, 1, 2].map(|i| (group.center[i] + group.half[i]).fast_min(cut_max[i]));
        let whole = low[0].simd_le(high[0]) & low[1].simd_le(high[1]) & low[2].simd_le(high[2]);
        let whole = if lanes == 0xff {
            whole
        } else {
            whole & lane_mask(lanes)
        };
        for axis in 0..3 {
            min[axis] = min[axis].fast_min(whole.bitselect(low[axis], min[axis]));
            max[axis] = max[axis].fast_max(whole.bitselect(high[axis], max[axis]));
        }
    }
    reduce(min, max)
}
