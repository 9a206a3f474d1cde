//! Bounds in flat arrays, in groups of eight, as the tests of `box_tests` read them.

use glam::{DVec3, Vec3};
use wide::f32x8;

use crate::geometry::Aabb;

/// Number of objects in one word of a bitset.
pub const WORD: usize = usize::BITS as usize;

/// Number of boxes in one group.
pub(in crate::sets) const LANES: usize = 8;

/// Number of groups in one word.
pub(in crate::sets) const GROUPS: usize = WORD / LANES;

/// Half size of a lane that holds no object. It fails every test, and is far enough from the limits of `f32`
/// that no test overflows.
const ABSENT: f32 = -1e15;

/// Boxes as centres and half sizes, [padded](Aabb::padded) so that the `f32` tests never exclude wrongly. The
/// array is filled up to whole words with lanes that fail every test.
#[derive(Clone, Debug, Default)]
pub struct Boxes {
    pub(in crate::sets) groups: Vec<Group>,
    len: usize,
}

/// Eight boxes: three cache lines, loaded into vector registers without conversion.
#[derive(Clone, Copy, Debug)]
pub(in crate::sets) struct Group {
    pub(in crate::sets) center: [f32x8; 3],
    pub(in crate::sets) half: [f32x8; 3],
}

impl Group {
    pub(in crate::sets) const ABSENT: Self = Self {
        center: [f32x8::ZERO; 3],
        half: [f32x8::new([ABSENT; LANES]); 3],
    };

    /// Writes the padded boxes into the lanes of `mask`. Bit for bit the same as calling [`Boxes::set`] for
    /// each.
    pub(in crate::sets) fn write(&mut self, boxes: &[Aabb], mask: usize) {
        let lanes = |coordinate: fn(&Aabb) -> f32| {
            let mut lanes = [0.0; LANES];
            for (lane, aabb) in lanes.iter_mut().zip(boxes) {
                *lane = coordinate(aabb);
            }
            f32x8::new(lanes)
        };
        let min = [lanes(|b| b.min.x), lanes(|b| b.min.y), lanes(|b| b.min.z)];
        let max = [lanes(|b| b.max.x), lanes(|b| b.max.y), lanes(|b| b.max.z)];
        let whole = min[0].simd_le(max[0]) & min[1].simd_le(max[1]) & min[2].simd_le(max[2]);
        let limit = f32x8::splat(Aabb::LIMIT);
        let clamp = |x: f32x8| x.fast_max(-limit).fast_min(limit);
        let (min, max) = (min.map(clamp), max.map(clamp));
        let size = [0, 1, 2].map(|axis| min[axis].abs().fast_max(max[axis].abs()));
        let largest = size[0].fast_max(size[1]).fast_max(size[2]);
        let write = lane_mask(mask);
        for axis in 0..3 {
            let pad = size[axis] * f32x8::splat(Aabb::PAD) + largest * f32x8::splat(Aabb::PAD_OF_LARGEST);
            let (min, max) = (min[axis] - pad, max[axis] + pad);
            let half_size = f32x8::splat(0.5);
            let center = whole.bitselect((min + max) * half_size, f32x8::ZERO);
            let half = whole.bitselect((max - min) * half_size, f32x8::splat(ABSENT));
            self.center[axis] = write.bitselect(center, self.center[axis]);
            self.half[axis] = write.bitselect(half, self.half[axis]);
        }
    }

    /// Stores one box without padding, or marks the lane absent if the box is empty.
    pub(in crate::sets) fn set(&mut self, lane: usize, aabb: &Aabb) {
        let (center, half) = if aabb.is_empty() {
            (Vec3::ZERO, Vec3::splat(ABSENT))
        } else {
            (aabb.center(), aabb.half_size())
        };
        for axis in 0..3 {
            self.center[axis].as_mut_array()[lane] = center[axis];
            self.half[axis].as_mut_array()[lane] = half[axis];
        }
    }

    /// Bits of the lanes that hold a box.
    pub(in crate::sets) fn present(&self) -> usize {
        self.half[0].simd_ge(f32x8::ZERO).to_bitmask() as usize & 0xff
    }
}

/// A vector whose lanes have all bits set where the mask has a bit, and none elsewhere.
pub(in crate::sets) fn lane_mask(mask: usize) -> f32x8 {
    let lane = |i: usize| f32::from_bits(((mask >> i & 1) as u32).wrapping_neg());
    f32x8::new(std::array::from_fn(lane))
}

impl Boxes {
    /// Number of boxes.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no boxes.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number of bitset words that hold all boxes.
    pub fn words(&self) -> usize {
        self.len.div_ceil(WORD)
    }

    /// Sets the number of boxes to `len` and makes all of them absent. Keeps the allocations.
    pub fn reset(&mut self, len: usize) {
        self.len = len;
        self.groups.clear();
        self.groups.resize(len.div_ceil(WORD) * GROUPS, Group::ABSENT);
    }

    /// Stores the padded box, or marks the lane absent if the box is empty.
    pub fn set(&mut self, index: usize, aabb: &Aabb) {
        self.set_unpadded(index, &aabb.padded());
    }

    /// Stores the box without padding.
    pub(in crate::sets) fn set_unpadded(&mut self, index: usize, aabb: &Aabb) {
        self.groups[index / LANES].set(index % LANES, aabb);
    }

    /// Centre and half size of a padded box, in `f64`.
    pub fn center_half(&self, index: usize) -> (DVec3, DVec3) {
        let (center, half) = self.load(index);
        (center.as_dvec3(), half.as_dvec3())
    }

    /// The padded box. It is empty if the lane is absent.
    pub fn get(&self, index: usize) -> Aabb {
        let (center, half) = self.load(index);
        if half.x < 0.0 {
            return Aabb::EMPTY;
        }
        Aabb::around(center, half)
    }

    #[inline]
    pub(in crate::sets) fn load(&self, index: usize) -> (Vec3, Vec3) {
        let group = &self.groups[index / LANES];
        let read =
            |lanes: &[f32x8; 3]| Vec3::from_array(lanes.each_ref().map(|v| v.as_array()[index % LANES]));
        (read(&group.center), read(&group.half))
    }

    /// The groups of a word.
    pub(in crate::sets) fn word(&self, word: usize) -> &[Group] {
        &self.groups[word * GROUPS..][..GROUPS]
    }
}
