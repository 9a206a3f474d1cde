//! Circular cone with a spherical end: what a spot light reaches.

use glam::{Vec3, Vec4};

use super::{Aabb, Sphere};

/// A cone from `apex` along `axis` up to `range` from the apex. With a half-angle of π/2 it is half a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Metres.
    pub apex: Vec3,
    /// Unit vector.
    pub axis: Vec3,
    /// Half-angle, radians; 0 < angle ≤ π/2.
    pub half_angle: f32,
    /// Metres; may be infinite.
    pub range: f32,
}

impl Cone {
    /// How far the cone reaches from its apex along a unit vector, metres: exact, 0 or more.
    pub fn extent(&self, direction: Vec3) -> f32 {
        let angle = direction.dot(self.axis).clamp(-1.0, 1.0).acos();
        let beyond = (angle - self.half_angle).max(0.0);
        if beyond >= std::f32::consts::FRAC_PI_2 {
            0.0
        } else {
            self.range * beyond.cos()
        }
    }

    /// The box around the cone; infinite on the sides where the cone is.
    pub fn aabb(&self) -> Aabb {
        let reach = |direction: Vec3| self.extent(direction);
        // `acos` loses half the digits near 0 and π; the pad is more than that loses of the cosine.
        let pad = |length: f32| {
            length * (1.0 + 1e-6) + 1e-6 * if self.range.is_finite() { self.range } else { 0.0 }
        };
        Aabb {
            min: self.apex - Vec3::from_array([Vec3::X, Vec3::Y, Vec3::Z].map(|axis| pad(reach(-axis)))),
            max: self.apex + Vec3::from_array([Vec3::X, Vec3::Y, Vec3::Z].map(|axis| pad(reach(axis)))),
        }
    }

    /// Homogeneous corners of the pyramid around the cone, apex first: oriented along the axis, so tighter than
    /// [`Cone::aabb`] for a narrow cone. Infinite range gives directions (`w = 0`). `None` for half-angles above
    /// 1.2 rad, where the pyramid's base is so wide that it bounds nothing.
    pub fn bounding_points(&self) -> Option<[Vec4; 5]> {
        if self.half_angle > 1.2 {
            return None;
        }
        let (x, y) = self.axis.any_orthonormal_pair();
        let slope = self.half_angle.tan() * (1.0 + 1e-5);
        let mut points = [self.apex.extend(1.0); 5];
        for (point, (sx, sy)) in
            points[1..]
                .iter_mut()
                .zip([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
        {
            let ray = self.axis + (x * sx + y * sy) * slope;
            *point = if self.range.is_finite() {
                (self.apex + ray * (self.range * (1.0 + 1e-5))).extend(1.0)
            } else {
                ray.extend(0.0)
            };
        }
        Some(points)
    }

    /// Whether the box lies wholly outside. Conservative: `false` for some boxes that miss the cone, never `true` for
    /// a box that touches it.
    ///
    /// Three tests, each exact for its own convex bound: the ball of the range, the half-space in front of the apex,
    /// and the tangent plane of the cone that faces the box's centre. A box's corner may slip between them.
    pub fn excludes_aabb(&self, aabb: &Aabb) -> bool {
        if aabb.is_empty() {
            return true;
        }
        let ball = Sphere {
            center: self.apex,
            radius: self.range * (1.0 + 4.0 * f32::EPSILON),
        };
        let aabb = aabb.padded();
        if self.range.is_finite() && !ball.intersects_aabb(&aabb) {
            return true;
        }
        let (to_center, half) = (aabb.center() - self.apex, aabb.half_size());
        let slack = 8.0 * f32::EPSILON * to_center.abs().element_sum();
        let along = to_center.dot(self.axis);
        if along + self.axis.abs().dot(half) + slack < 0.0 {
            return true;
        }
        let (x, y) = self.axis.any_orthonormal_pair();
        let towards = x * to_center.dot(x) + y * to_center.dot(y);
        let towards = towards.try_normalize().unwrap_or(x);
        let (sin, cos) = self.half_angle.sin_cos();
        let normal = self.axis * sin - towards * cos;
        normal.dot(to_center) + normal.abs().dot(half) + slack < 0.0
    }
}
