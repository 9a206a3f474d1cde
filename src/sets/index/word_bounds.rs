//! Bounds of the boxes of a word.

use glam::Vec3;
use wide::f32x8;

use super::boxes::Group;
use crate::geometry::Aabb;

/// The box around the boxes of a word. It is empty if all lanes are absent.
pub(in crate::sets) fn word_bounds(groups: &[Group]) -> Aabb {
    let mut min = [f32x8::splat(f32::INFINITY); 3];
    let mut max = [f32x8::splat(f32::NEG_INFINITY); 3];
    for group in groups {
        for axis in 0..3 {
            // Absent boxes have negative sizes. They change neither bound unless no other box exists.
            min[axis] = min[axis].fast_min(group.center[axis] - group.half[axis]);
            max[axis] = max[axis].fast_max(group.center[axis] + group.half[axis]);
        }
    }
    reduce(min, max)
}

/// Joins the boxes of all lanes.
pub(super) fn reduce(min: [f32x8; 3], max: [f32x8; 3]) -> Aabb {
    let fold = |lanes: [f32x8; 3], f: fn(f32, f32) -> f32| {
        Vec3::from_array(lanes.map(|v| v.to_array().into_iter().reduce(f).unwrap_or(f32::NAN)))
    };
    Aabb {
        min: fold(min, f32::min),
        max: fold(max, f32::max),
    }
}
