//! Coordinates in which the view frustum is simple.
//!
//! They are affine in world space: x and y of clip space before the division, and depth along the view. In a
//! perspective view a point is on the screen if |x| and |y| are at most its depth; in an orthographic view, if
//! they are at most 1.

use glam::{DMat3, DMat4, DVec3, DVec4};
use smallvec::SmallVec;

use crate::sets::ViewData;

/// The coordinates of one view.
#[derive(Clone, Debug)]
pub struct ViewSpace {
    /// Linear part of the transform from world axes.
    pub from_axes: DMat3,
    /// Transform back from a vector of view coordinates to world axes.
    pub to_axes: DMat3,
    /// View coordinates of the eye.
    pub eye: DVec3,
    /// The eye in world space, metres.
    pub eye_world: DVec3,
    /// Half-spaces `(n, d)` of the frustum, `n · p + d ≥ 0`, in view coordinates.
    pub half_spaces: SmallVec<[DVec4; 8]>,
    /// Depth of the near plane.
    pub near: f64,
    /// Whether the view is a perspective.
    pub is_perspective: bool,
}

impl ViewSpace {
    /// Returns the coordinates of a view. `None` if the view is flat.
    pub fn new(view: &ViewData) -> Option<Self> {
        let rows = (view.clip_from_world * DMat4::from_translation(view.eye)).transpose();
        let is_perspective = !view.is_orthographic();
        let depth = if is_perspective {
            rows.w_axis
        } else {
            -(view.view_from_world * DMat4::from_translation(view.eye))
                .transpose()
                .z_axis
        };
        let rows = [rows.x_axis, rows.y_axis, depth];
        let from_axes = DMat3::from_cols_array_2d(&rows.map(|row| row.truncate().to_array())).transpose();
        let to_axes = from_axes.inverse();
        let near = if is_perspective {
            view.near
        } else {
            view.frustum.shape().near
        };
        let (side, one) = if is_perspective { (1.0, 0.0) } else { (0.0, 1.0) };
        let mut half_spaces = SmallVec::from_slice(&[
            DVec4::new(0.0, 0.0, 1.0, -near),
            DVec4::new(1.0, 0.0, side, one),
            DVec4::new(-1.0, 0.0, side, one),
            DVec4::new(0.0, 1.0, side, one),
            DVec4::new(0.0, -1.0, side, one),
        ]);
        half_spaces.extend(view.frustum.far().map(|far| DVec4::new(0.0, 0.0, -1.0, far)));
        (from_axes.is_finite() && to_axes.is_finite()).then_some(Self {
            from_axes,
            to_axes,
            eye: DVec3::from_array(rows.map(|row| row.w)),
            eye_world: view.eye,
            half_spaces,
            near,
            is_perspective,
        })
    }

    /// Returns view coordinates of a point of world space.
    pub fn point(&self, world: DVec3) -> DVec3 {
        self.from_axes * (world - self.eye_world) + self.eye
    }

    /// Returns view coordinates of a homogeneous point of world space: a point with w = 1, a direction with
    /// w = 0.
    pub fn homogeneous(&self, world: DVec4) -> DVec4 {
        if world.w == 0.0 {
            (self.from_axes * world.truncate()).extend(0.0)
        } else {
            self.point(world.truncate()).extend(1.0)
        }
    }

    /// Returns a half-space of world space, `normal · (point − through) ≥ 0`, in view coordinates.
    pub fn half_space(&self, normal: DVec3, through: DVec3) -> DVec4 {
        let normal = self.to_axes.transpose() * normal;
        normal.extend(-normal.dot(self.point(through)))
    }

    /// Returns the line of sight of a place of the screen, NDC, in world axes from the eye: a point and a
    /// direction of any length.
    pub fn line_of_sight(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        if self.is_perspective {
            (self.to_axes * -self.eye, self.to_axes * DVec3::new(x, y, 1.0))
        } else {
            (
                self.to_axes * (DVec3::new(x, y, self.near) - self.eye),
                self.to_axes * DVec3::Z,
            )
        }
    }
}
