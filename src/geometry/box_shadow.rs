//! How far the shadow of a box matters. This is the counterpart of a finite shadow volume, for boxes.

use glam::{DVec3, Vec3};
use wide::f32x8;

use super::Aabb;

/// Boxes that receive the light of a point light, and how far the shadow of another box matters to them.
///
/// The region that a box may shadow is the box itself, and everything behind it as seen from the light. With the light at the
/// origin, a point `p` of that region is `t ≥ 1` times as far from the light as a point `q` of the box: `p = t q`. For a given
/// `t`, the box scaled by `t` meets another box if they overlap on every axis: `t · min ≤ other.max` and
/// `t · max ≥ other.min`. Each axis thus bounds `t`, and the factors that all three axes allow form an interval.
#[derive(Clone, Debug, Default)]
pub struct BoxReceivers {
    light: DVec3,
    groups: Vec<Group>,
}

/// Number of boxes in a group.
const LANES: usize = 8;

/// Eight boxes, relative to the light.
#[derive(Clone, Copy, Debug)]
struct Group {
    min: [f32x8; 3],
    max: [f32x8; 3],
}

impl BoxReceivers {
    /// Share by which the interval of factors is widened at both ends, to cover rounding.
    const SLACK: f32 = 1e-5;

    /// Replaces the light and the boxes, and keeps the memory. Both are in the same space. The boxes are not empty.
    pub fn set(&mut self, light: DVec3, boxes: &[Aabb]) {
        self.light = light;
        self.groups.clear();
        self.groups.extend(boxes.chunks(LANES).map(|chunk| {
            // Lanes without a box repeat the last one, which changes no maximum.
            let lanes: [Aabb; LANES] =
                std::array::from_fn(|lane| relative_to(light, &chunk[lane.min(chunk.len() - 1)]));
            Group {
                min: [0, 1, 2].map(|axis| f32x8::new(lanes.map(|lane| lane.min[axis]))),
                max: [0, 1, 2].map(|axis| f32x8::new(lanes.map(|lane| lane.max[axis]))),
            }
        }));
    }

    /// The greatest factor on distances from the light at which a caster's shadow meets one of the boxes. It is infinite if the
    /// light lies within the bounds of the caster, because nothing then bounds the factor; it is `None` if the caster shadows
    /// no point of any box. The caster's bounds are not empty.
    ///
    /// Conservative: rounding may make a factor too large, never too small. Cost: the boxes, eight at a time.
    pub fn farthest(&self, caster: &Aabb) -> Option<f32> {
        let relative = relative_to(self.light, caster);
        let (per_min, per_max) = (relative.min.recip(), relative.max.recip());
        let infinity = f32x8::splat(f32::INFINITY);
        let mut farthest = -infinity;
        for group in &self.groups {
            let (mut least, mut most) = (f32x8::splat(1.0), infinity);
            for axis in 0..3 {
                // A bound at the light's own coordinate has an infinite reciprocal; it does not limit the factor.
                let bounds = [
                    (per_min[axis], group.max[axis]),
                    (-per_max[axis], -group.min[axis]),
                ];
                for (per_bound, limit) in bounds {
                    let factor = f32x8::splat(per_bound.abs()) * limit;
                    let is_finite = factor.abs().simd_lt(infinity);
                    if per_bound > 0.0 {
                        most = is_finite.bitselect(most.fast_min(factor), most);
                    } else {
                        least = is_finite.bitselect(least.fast_max(-factor), least);
                    }
                }
            }
            most *= f32x8::splat(1.0 + Self::SLACK);
            let meets = (least * f32x8::splat(1.0 - Self::SLACK)).simd_le(most);
            farthest = meets.bitselect(farthest.fast_max(most), farthest);
        }
        let farthest = farthest.to_array().into_iter().fold(f32::NEG_INFINITY, f32::max);
        (farthest > f32::NEG_INFINITY).then_some(farthest)
    }
}

/// The box relative to a position, grown by as much as rounding may lose.
fn relative_to(origin: DVec3, aabb: &Aabb) -> Aabb {
    let aabb = aabb.padded();
    let relative = |corner: Vec3| (corner.as_dvec3() - origin).as_vec3();
    Aabb {
        min: relative(aabb.min),
        max: relative(aabb.max),
    }
    .padded()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn aabb() -> impl Strategy<Value = Aabb> {
        let coordinate = || prop_oneof![Just(0.0_f32), -4.0_f32..4.0];
        let corner = move || (coordinate(), coordinate(), coordinate());
        (corner(), corner()).prop_map(|(a, b)| Aabb::from_points([a.into(), b.into()]))
    }

    fn farthest(light: DVec3, caster: &Aabb, boxes: &[Aabb]) -> Option<f32> {
        let mut receivers = BoxReceivers::default();
        receivers.set(light, boxes);
        receivers.farthest(caster)
    }

    fn at(aabb: &Aabb, share: (f32, f32, f32)) -> DVec3 {
        (aabb.min + (aabb.max - aabb.min) * Vec3::from(share)).as_dvec3()
    }

    proptest! {
        /// Every point of a receiver that lies behind a point of the caster, as seen from the light, is
        /// within the factor.
        #[test]
        fn no_shadowed_point_lies_beyond(
            light in (-4.0_f64..4.0, -4.0_f64..4.0, -4.0_f64..4.0),
            caster in aabb(),
            share in (0.0_f32..=1.0, 0.0_f32..=1.0, 0.0_f32..=1.0),
            factor in 1.0_f64..20.0,
            size in 0.0_f32..2.0,
        ) {
            let light = DVec3::from(light);
            let shadowed = light + (at(&caster, share) - light) * factor;
            let point = shadowed.as_vec3();
            let receiver = Aabb { min: point - size, max: point + 0.5 * size };
            let found = farthest(light, &caster, &[receiver]);
            let found = found.expect("it is shadowed");
            prop_assert!(f64::from(found) >= factor * (1.0 - 1e-5), "{found} < {factor}");
        }

        /// The factor is as small as it can be: the boxes touch there.
        #[test]
        fn the_boxes_touch_at_the_factor(
            light in (-4.0_f64..4.0, -4.0_f64..4.0, -4.0_f64..4.0),
            caster in aabb(),
            receiver in aabb(),
        ) {
            let light = DVec3::from(light);
            if let Some(factor) = farthest(light, &caster, &[receiver])
                && factor < 1e3
            {
                let grown = |corner: Vec3| (light + (corner.as_dvec3() - light) * f64::from(factor)).as_vec3();
                let grown = Aabb { min: grown(caster.min), max: grown(caster.max) };
                let gap = (grown.min - receiver.max).max(receiver.min - grown.max).max_element();
                prop_assert!(gap <= 1e-3 * factor, "{gap}");
            }
        }

        /// Boxes that are tested together give what the farthest of them gives alone, however many there are.
        #[test]
        fn many_boxes_give_what_the_farthest_gives(
            light in (-4.0_f64..4.0, -4.0_f64..4.0, -4.0_f64..4.0),
            caster in aabb(),
            boxes in prop::collection::vec(aabb(), 0..20),
        ) {
            let light = DVec3::from(light);
            let alone = boxes.iter().filter_map(|one| farthest(light, &caster, &[*one]));
            prop_assert_eq!(farthest(light, &caster, &boxes), alone.reduce(f32::max));
        }
    }

    #[test]
    fn a_floor_ends_the_shadow_and_a_ceiling_has_none() {
        let flat = |y: f32, half: f32| Aabb {
            min: Vec3::new(-half, y, -half),
            max: Vec3::new(half, y, half),
        };
        let shadow = |boxes: &[Aabb]| farthest(DVec3::new(0.0, 3.0, 0.0), &flat(2.0, 0.1), boxes);
        let on_floor = shadow(&[flat(0.0, 10.0)]).expect("the floor is shadowed");
        assert!((on_floor - 3.0).abs() < 1e-3, "{on_floor}");
        assert_eq!(shadow(&[flat(4.0, 10.0)]), None);
        assert_eq!(shadow(&[]), None);
        let of_both = shadow(&[flat(4.0, 10.0), flat(1.0, 10.0), flat(0.0, 10.0)]);
        assert_eq!(of_both, Some(on_floor));
    }

    #[test]
    fn a_light_within_the_box_knows_no_end() {
        let unit = Aabb {
            min: Vec3::splat(-1.0),
            max: Vec3::ONE,
        };
        assert_eq!(farthest(DVec3::ZERO, &unit, &[unit]), Some(f32::INFINITY));
    }
}
