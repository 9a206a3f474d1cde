//! Which triangles share a cluster.

use glam::Vec3;

use crate::conventions::CLUSTER_TRIANGLES;

/// How far apart two opposite normals count, in half sizes of the part that is split.
///
/// Measured (`benches/silhouettes.rs`) as the share of clusters that a light finds mixed, at 0, 2, 4, 8:
/// icosphere of 20k triangles 11, 11, 11, 11 %, deer 86, 49, 27, 27 %, interior 87, 55, 17, 11 %. More than 4 wins
/// little and tears clusters apart: seams and memory grow.
const NORMAL_WEIGHT: f32 = 4.0;

/// A triangle while it is sorted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// Sum of its corners; only comparisons matter.
    pub centroid: Vec3,
    /// Unit length, or zero.
    pub normal: Vec3,
    /// Place in the order of the input.
    pub triangle: u32,
}

/// Sorts triangles so that each run of [`CLUSTER_TRIANGLES`] is compact and its normals are close, which is what
/// makes clusters face uniformly. All runs but the last are full.
///
/// Halves the triangles again and again across the axis in which they spread the most: one of three of
/// position, or one of three of normal.
pub(super) fn cluster_order(items: &mut [Item]) {
    let mut parts = vec![items];
    while let Some(part) = parts.pop() {
        if part.len() <= CLUSTER_TRIANGLES {
            // The order inside of a cluster is free: that of the input is kept, as it is kind to vertex caches.
            part.sort_unstable_by_key(|item| item.triangle);
            continue;
        }
        let (left, right) = split(part);
        parts.push(right);
        parts.push(left);
    }
}

/// Splits at a multiple of the cluster size near the middle.
fn split(part: &mut [Item]) -> (&mut [Item], &mut [Item]) {
    let clusters = part.len().div_ceil(CLUSTER_TRIANGLES);
    let middle = clusters / 2 * CLUSTER_TRIANGLES;
    let spread = |of: fn(&Item) -> Vec3| {
        let (low, high) = part
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), item| {
                (low.min(of(item)), high.max(of(item)))
            });
        high - low
    };
    let (size, turn) = (spread(|item| item.centroid), spread(|item| item.normal));
    let turn = turn * size.max_element() * (0.5 * NORMAL_WEIGHT);
    let by_normal = turn.max_element() > size.max_element();
    let axis = if by_normal { turn } else { size }.max_position();
    let key = |item: &Item| {
        if by_normal {
            item.normal[axis]
        } else {
            item.centroid[axis]
        }
    };
    // The place in the input decides between equals, so that the result has one order.
    part.select_nth_unstable_by(middle, |a, b| {
        key(a).total_cmp(&key(b)).then(a.triangle.cmp(&b.triangle))
    });
    part.split_at_mut(middle)
}
