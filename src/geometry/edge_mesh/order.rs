//! The order of triangles, which decides which of them share a cluster.

use glam::Vec3;

use crate::conventions::CLUSTER_TRIANGLES;

/// How far apart two opposite normals count as being, in multiples of the largest extent of the part that is
/// split. Higher values make the normals within a cluster more alike; lower values make clusters more
/// compact.
///
/// Measured (`benches/silhouettes.rs`) as the share of clusters in which a light finds both facing and
/// non-facing triangles, at 0, 2, 4, 8: icosphere of 20k triangles 11, 11, 11, 11 %, deer 86, 49, 27, 27 %,
/// interior 87, 55, 17, 11 %. More than 4 gains little and tears clusters apart, so that seams and memory
/// grow.
const NORMAL_WEIGHT: f32 = 4.0;

/// The sort key of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// Mean of the triangle's corners.
    pub centroid: Vec3,
    /// Unit normal of the triangle, or zero if it has no area.
    pub normal: Vec3,
    /// Index of the triangle in the input.
    pub triangle: u32,
}

/// Sorts triangles so that each run of [`CLUSTER_TRIANGLES`] is compact and has similar normals. Such
/// clusters tend to face a light uniformly. All runs except the last are full.
///
/// The triangles are halved again and again across the axis in which they spread most: one of three axes of
/// position, or one of three of normal.
pub(super) fn cluster_order(items: &mut [Item]) {
    let mut parts = vec![items];
    while let Some(part) = parts.pop() {
        if part.len() <= CLUSTER_TRIANGLES {
            // Order within a cluster is free. The input's order is kept, because it suits vertex caches.
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
    // The index in the input breaks ties, so that the result is unique.
    part.select_nth_unstable_by(middle, |a, b| {
        key(a).total_cmp(&key(b)).then(a.triangle.cmp(&b.triangle))
    });
    part.split_at_mut(middle)
}
