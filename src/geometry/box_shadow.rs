//! How far the shadow of a box matters. This is the counterpart of a finite shadow volume, for boxes.

use glam::{DVec3, Vec3};

use super::Aabb;

/// The region that a box may shadow in a point light: the box itself, and everything behind it as seen from
/// the light.
///
/// With the light at the origin, a point `p` of that region is `t ≥ 1` times as far from the light as a point
/// `q` of the box: `p = t q`. For a given `t`, the box scaled by `t` meets another box if they overlap on
/// every axis: `t · min ≤ other.max` and `t · max ≥ other.min`. Each axis thus bounds `t`, and the factors
/// that all three axes allow form an interval.
#[derive(Clone, Copy, Debug)]
pub struct BoxShadow {
    light: DVec3,
    /// Reciprocals of the caster's lower bounds relative to the light, one an axis.
    per_min: Vec3,
    per_max: Vec3,
}

impl BoxShadow {
    /// Share by which the interval of factors is widened at both ends, to cover rounding.
    const SLACK: f32 = 1e-5;

    /// The shadow of a box that is not empty, in a light at a position. Both are in the same space.
    pub fn new(light: DVec3, caster: &Aabb) -> Self {
        let relative = relative_to(light, caster);
        Self {
            light,
            per_min: relative.min.recip(),
            per_max: relative.max.recip(),
        }
    }

    /// The greatest factor on distances from the light at which the box's shadow meets one of the other
    /// boxes. It is infinite if the light lies within the box's bounds, because nothing then bounds the
    /// factor; it is `None` if the box shadows no point of any other box.
    ///
    /// Conservative: rounding may make a factor too large, never too small.
    pub fn farthest(&self, receivers: &[Aabb]) -> Option<f32> {
        let factors = receivers
            .iter()
            .filter_map(|receiver| self.factors(&relative_to(self.light, receiver)));
        factors.reduce(f32::max)
    }

    /// The greatest factor for one box, which is given relative to the light.
    fn factors(&self, receiver: &Aabb) -> Option<f32> {
        let (mut least, mut most) = (1.0_f32, f32::INFINITY);
        for axis in 0..3 {
            // A bound at the light's own coordinate has an infinite reciprocal; it does not limit the factor.
            let bounds = [
                (self.per_min[axis], receiver.max[axis]),
                (-self.per_max[axis], -receiver.min[axis]),
            ];
            for (per_bound, limit) in bounds {
                let factor = per_bound.abs() * limit;
                if !factor.is_finite() {
                    continue;
                }
                if per_bound > 0.0 {
                    most = most.min(factor);
                } else {
                    least = least.max(-factor);
                }
            }
        }
        (least * (1.0 - Self::SLACK) <= most * (1.0 + Self::SLACK)).then_some(most * (1.0 + Self::SLACK))
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
            let found = BoxShadow::new(light, &caster).farthest(&[receiver]);
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
            if let Some(factor) = BoxShadow::new(light, &caster).farthest(&[receiver])
                && factor < 1e3
            {
                let grown = |corner: Vec3| (light + (corner.as_dvec3() - light) * f64::from(factor)).as_vec3();
                let grown = Aabb { min: grown(caster.min), max: grown(caster.max) };
                let gap = (grown.min - receiver.max).max(receiver.min - grown.max).max_element();
                prop_assert!(gap <= 1e-3 * factor, "{gap}");
            }
        }
    }

    #[test]
    fn a_floor_ends_the_shadow_and_a_ceiling_has_none() {
        let flat = |y: f32, half: f32| Aabb {
            min: Vec3::new(-half, y, -half),
            max: Vec3::new(half, y, half),
        };
        let shadow = BoxShadow::new(DVec3::new(0.0, 3.0, 0.0), &flat(2.0, 0.1));
        let on_floor = shadow
            .farthest(&[flat(0.0, 10.0)])
            .expect("the floor is shadowed");
        assert!((on_floor - 3.0).abs() < 1e-3, "{on_floor}");
        assert_eq!(shadow.farthest(&[flat(4.0, 10.0)]), None);
        assert_eq!(shadow.farthest(&[]), None);
        let of_both = shadow.farthest(&[flat(4.0, 10.0), flat(1.0, 10.0), flat(0.0, 10.0)]);
        assert_eq!(of_both, Some(on_floor));
    }

    #[test]
    fn a_light_within_the_box_knows_no_end() {
        let unit = Aabb {
            min: Vec3::splat(-1.0),
            max: Vec3::ONE,
        };
        let shadow = BoxShadow::new(DVec3::ZERO, &unit);
        assert_eq!(shadow.farthest(&[unit]), Some(f32::INFINITY));
    }
}
