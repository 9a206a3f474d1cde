//! The view.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DMat4, Mat4, Vec2};

/// A perspective camera at its `GlobalTransform`, looking along local −Z. Its depth is reversed and infinite
/// ([`conventions`](crate::conventions)). A transform that mirrors gives a mirrored view.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[require(Transform)]
pub struct Camera {
    /// Vertical field of view, radians; 0 < fov < π.
    pub vertical_fov: f32,
    /// Distance of the near plane, metres; > 0.
    pub near: f32,
    /// Width over height of the picture; > 0.
    pub aspect: f32,
    /// NDC by which the picture is moved, right and up: an off-centre lens, or the jitter of temporal anti-aliasing.
    pub shift: Vec2,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            vertical_fov: std::f32::consts::FRAC_PI_4,
            near: 0.1,
            aspect: 16.0 / 9.0,
            shift: Vec2::ZERO,
        }
    }
}

impl Camera {
    /// Whether the numbers make a projection.
    pub fn is_valid(&self) -> bool {
        self.vertical_fov > 0.0
            && self.vertical_fov < std::f32::consts::PI
            && self.near > 0.0
            && self.near.is_finite()
            && self.aspect > 0.0
            && self.aspect.is_finite()
            && self.shift.is_finite()
    }

    /// Half the size of the picture at distance 1, as (right, up); its centre is at minus `shift` times that.
    pub fn half_extent_at_unit_distance(&self) -> (f64, f64) {
        let up = (f64::from(self.vertical_fov) * 0.5).tan();
        (up * f64::from(self.aspect), up)
    }

    /// Reversed infinite projection: `z_clip = near`, `w_clip = −z_view`.
    pub fn clip_from_view(&self) -> DMat4 {
        let (right, up) = self.half_extent_at_unit_distance();
        let mut m = DMat4::ZERO;
        m.x_axis.x = 1.0 / right;
        m.y_axis.y = 1.0 / up;
        m.z_axis.x = -f64::from(self.shift.x);
        m.z_axis.y = -f64::from(self.shift.y);
        m.z_axis.w = -1.0;
        m.w_axis.z = f64::from(self.near);
        m
    }

    /// World to view for a camera at `world_from_camera`; `None` if that is singular or not finite.
    pub fn view_from_world(world_from_camera: &GlobalTransform) -> Option<DMat4> {
        let world_from_view = Mat4::from(world_from_camera.affine()).as_dmat4();
        let determinant = world_from_view.determinant();
        (determinant.is_finite() && determinant != 0.0)
            .then(|| world_from_view.inverse())
            .filter(|m| m.is_finite())
    }
}
