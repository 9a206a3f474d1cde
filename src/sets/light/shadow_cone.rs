//! The cone that holds what a spot light lights, as seen from the place of its shadows.

use std::f64::consts::PI;

use glam::DVec3;

use super::frame_light::FrameLight;
use super::light_volume::LightVolume;
use crate::scene::LightKind;

impl FrameLight {
    /// Returns the cone that holds what a spot light lights, as seen from the place of its shadows: the unit axis and the
    /// half-angle in radians. The half-angle is at most π/2, or π if the place was moved to where lit space is all
    /// around it. `None` for lights of other kinds.
    pub fn shadow_cone(&self) -> Option<(DVec3, f64)> {
        let LightKind::Spot { outer_angle, .. } = self.light.kind else {
            return None;
        };
        let axis = self.direction.as_dvec3().normalize();
        let half_angle = match self.lit.volume {
            LightVolume::Cone(cone) => f64::from(cone.half_angle),
            _ => f64::from(outer_angle),
        };
        if self.model.origin.is_none() {
            return Some((axis, half_angle));
        }
        let eye = self.point_world.truncate();
        let apex = self.shining.emitter.point.truncate();
        let around_cone = around_cone(apex - eye, axis, half_angle);
        let lit = self.lit.aabb();
        if !(lit.min.is_finite() && lit.max.is_finite()) {
            return Some(around_cone);
        }
        let to_lit = lit.center().as_dvec3() - eye;
        let around_ball = around_ball(to_lit, f64::from(lit.half_size().length()));
        Some(match around_ball {
            Some(around_ball) if around_ball.1 < around_cone.1 => around_ball,
            _ => around_cone,
        })
    }
}

/// Returns the axis and the half-angle of the smallest cone from an eye around an infinite cone, whose apex is at `to_apex`
/// from the eye. The half-angle is π if the eye is inside.
fn around_cone(to_apex: DVec3, axis: DVec3, half_angle: f64) -> (DVec3, f64) {
    let Some(to_apex) = to_apex.try_normalize() else {
        return (axis, half_angle);
    };
    let apart = to_apex.cross(axis).length().atan2(to_apex.dot(axis));
    if apart <= half_angle {
        return (axis, half_angle); // the eye is behind the apex
    }
    let side = (to_apex - axis * to_apex.dot(axis)).try_normalize();
    match side {
        // From the far side of the cone to its apex.
        Some(side) if apart + half_angle < PI => {
            let (sin, cos) = (0.5 * (apart - half_angle)).sin_cos();
            (axis * cos + side * sin, 0.5 * (apart + half_angle))
        }
        _ => (axis, PI),
    }
}

/// Returns the axis and the half-angle of the cone from an eye around a ball; `None` if the eye is inside.
fn around_ball(to_center: DVec3, radius: f64) -> Option<(DVec3, f64)> {
    let distance = to_center.length();
    (distance > radius).then(|| (to_center / distance, (radius / distance).asin()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number between −1 and 1.
    fn at(i: u32, k: u32) -> f64 {
        f64::from((i * k + 5) % 103) / 51.5 - 1.0
    }

    #[test]
    fn all_points_of_a_cone_are_in_the_cone_around_it() {
        let (mut inside, mut behind, mut beside) = (0, 0, 0);
        for i in 0..300 {
            let axis = DVec3::new(at(i, 7), at(i, 11), at(i, 17)).normalize();
            let half_angle = 0.1 + 0.7 * (1.0 + at(i, 23));
            let to_apex = DVec3::new(at(i, 3), at(i, 13), at(i, 29)) * 4.0;
            let (around, half) = around_cone(to_apex, axis, half_angle);
            let from_around = |to: DVec3| to.cross(around).length().atan2(to.dot(around));
            let (x, y) = axis.any_orthonormal_pair();
            let mut widest: f64 = 0.0;
            for k in 0..200_u32 {
                let (sin, cos) = (half_angle * f64::from(k % 5) / 4.0).sin_cos();
                let turn = f64::from(k) * 0.7;
                let ray = axis * cos + (x * turn.cos() + y * turn.sin()) * sin;
                let to_point = to_apex + ray * 4f64.powi(k as i32 % 11 - 4);
                widest = widest.max(from_around(to_point));
            }
            assert!(
                widest <= half + 1e-9,
                "{to_apex} {axis} {half_angle}: {widest} of {half}"
            );
            let is_inside = (-to_apex).normalize().dot(axis) > half_angle.cos();
            assert_eq!(half == PI, is_inside, "{to_apex} {axis} {half_angle}");
            if is_inside {
                inside += 1;
            } else if half == half_angle {
                behind += 1;
            } else {
                assert!((from_around(to_apex) - half).abs() < 1e-9, "it is the smallest");
                beside += 1;
            }
        }
        assert!(
            inside > 20 && behind > 20 && beside > 20,
            "{inside} {behind} {beside}"
        );
    }

    #[test]
    fn a_ball_is_seen_from_outside() {
        let (axis, half_angle) = around_ball(DVec3::Y * -2.0, 1.0).expect("the eye is outside");
        assert!(axis == DVec3::NEG_Y && (half_angle - PI / 6.0).abs() < 1e-12);
        assert_eq!(around_ball(DVec3::X, 1.5), None);
    }
}
