//! Bounds on the screen of many boxes, found by projecting only a few of them.

use fixedbitset::FixedBitSet;
use glam::DVec3;
use wide::f32x8;

use super::screen::{Projector, ScreenBounds};
use crate::sets::index::box_tests::splat;
use crate::sets::index::boxes::{GROUPS, Group, LANES, WORD};
use crate::sets::index::objects::Objects;

/// The union of the screen bounds of a set's boxes, and the number of boxes that were projected. The union is
/// exact only within `target`. `words` must have a bit for every word of the set that is not 0.
///
/// A box adds nothing if it lies inside the planes through the eye and the sides of the union so far, and
/// within its depth range. Eight boxes, or clusters of boxes, are tested at once against these planes without
/// being projected. Sides of the union that have left the target are no longer tested. Therefore only the
/// boxes that extend the union so far are projected.
pub(in crate::sets) fn screen_union(
    projector: &Projector,
    objects: &Objects,
    words: &FixedBitSet,
    set: impl Fn(usize) -> usize,
    target: ScreenBounds,
) -> (ScreenBounds, u64) {
    let mut union = Union::new(projector, target);
    for (block, &bits) in words.as_slice().iter().enumerate() {
        if bits == 0 {
            continue;
        }
        for (at, clusters) in objects.clusters.words.word(block).iter().enumerate() {
            let first = block * WORD + at * LANES;
            union.each_sticking_out(clusters, (bits >> (at * LANES)) & 0xff, |union, lane| {
                add_word(union, objects, first + lane, set(first + lane));
            });
        }
    }
    (union.bounds, union.projected)
}

fn add_word(union: &mut Union, objects: &Objects, word: usize, bits: usize) {
    for (at, group) in objects.boxes.word(word).iter().enumerate().take(GROUPS) {
        let first = word * WORD + at * LANES;
        union.each_sticking_out(group, (bits >> (at * LANES)) & 0xff, |union, lane| {
            let (center, half) = objects.boxes.center_half(first + lane);
            union.add(center, half);
        });
    }
}

/// The union so far.
struct Union<'a> {
    projector: &'a Projector,
    target: ScreenBounds,
    bounds: ScreenBounds,
    /// The planes of the union; a box inside all of them adds nothing. The first `asked` of them are tested.
    sides: [Side; 6],
    asked: usize,
    eye: [f32x8; 3],
    projected: u64,
}

/// A half-space relative to the eye. Inside is `normal · p + offset ≥ 0`.
#[derive(Clone, Copy)]
struct Side {
    normal: [f32x8; 3],
    offset: f32x8,
}

impl Side {
    /// A half-space without inside, which every box sticks out of.
    const NOWHERE: Self = Self {
        normal: [f32x8::ZERO; 3],
        offset: f32x8::new([-1.0; LANES]),
    };
}

impl<'a> Union<'a> {
    fn new(projector: &'a Projector, target: ScreenBounds) -> Self {
        Self {
            projector,
            target,
            bounds: ScreenBounds::EMPTY,
            sides: [Side::NOWHERE; 6],
            asked: 1,
            eye: splat(projector.eye().as_vec3()),
            projected: 0,
        }
    }

    fn add(&mut self, center: DVec3, half: DVec3) {
        self.projected += 1;
        let bounds = self.bounds.union(self.projector.bounds_of_box(center, half));
        if bounds != self.bounds {
            self.bounds = bounds;
            if !bounds.is_empty() {
                self.ask();
            }
        }
    }

    /// Calls `visit` for each box among `lanes` that sticks out of the union at the moment when it is
    /// reached.
    fn each_sticking_out(&mut self, group: &Group, lanes: usize, mut visit: impl FnMut(&mut Self, usize)) {
        let mut lanes = lanes;
        while lanes != 0 {
            lanes &= self.sticking_out(group);
            if lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                visit(self, lane);
            }
        }
    }

    /// Bits of the boxes that may add something. Rounding may include a box that adds nothing.
    fn sticking_out(&self, group: &Group) -> usize {
        let slack = f32x8::splat(16.0 * f32::EPSILON);
        let offset = [0, 1, 2].map(|i| group.center[i] - self.eye[i]);
        let reach = [0, 1, 2].map(|i| {
            let size = group.center[i].abs() + self.eye[i].abs() + group.half[i];
            group.half[i] + size * slack
        });
        let mut outside = 0;
        for Side { normal, offset: d } in &self.sides[..self.asked] {
            let distance = offset[0] * normal[0] + offset[1] * normal[1] + offset[2] * normal[2] + *d;
            let extent = reach[0] * normal[0].abs() + reach[1] * normal[1].abs() + reach[2] * normal[2].abs();
            outside |= (distance - extent).simd_lt(f32x8::ZERO).to_bitmask();
        }
        outside as usize & 0xff
    }

    /// Sets the planes through those sides of the bounds that are still within the target.
    ///
    /// A pixel coordinate x is s·(½ + ½·X/W), and W > 0 in view. Therefore x ≥ a where X − (2a/s − 1)·W ≥ 0.
    fn ask(&mut self) {
        let [x, y, w] = self.projector.rows();
        let depth = self.projector.depth_gradient();
        let (bounds, target, size) = (&self.bounds, &self.target, self.projector.size());
        let at = |pixel: f64, size: f64| 2.0 * pixel / size - 1.0;
        let left = x - w * at(bounds.min.x, size.x);
        let right = w * at(bounds.max.x, size.x) - x;
        let top = -y - w * at(bounds.min.y, size.y);
        let bottom = w * at(bounds.max.y, size.y) + y;
        let sides = [
            (left, bounds.min.x > target.min.x),
            (right, bounds.max.x < target.max.x),
            (top, bounds.min.y > target.min.y),
            (bottom, bounds.max.y < target.max.y),
            (depth.extend(-bounds.near), bounds.near > target.near),
            ((-depth).extend(bounds.far), bounds.far < target.far),
        ];
        self.asked = 0;
        for (side, within) in sides {
            if within {
                self.sides[self.asked] = Side {
                    normal: splat(side.truncate().as_vec3()),
                    offset: f32x8::splat(side.w as f32),
                };
                self.asked += 1;
            }
        }
    }
}
