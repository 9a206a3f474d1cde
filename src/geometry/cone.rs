//! Circular cone with a spherical end: the region that a spot light reaches.

use glam::{DVec4, Vec3};

use super::{Aabb, Sphere};

/// A cone from `apex` along `axis`, up to the distance `range` from the apex. With a half-angle of π/2 it is
/// half a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Tip of the cone, metres.
    pub apex: Vec3,
    /// Direction in which the cone opens; a unit vector.
    pub axis: Vec3,
    /// Angle between the axis and the cone's surface, radians; 0 < angle ≤ π/2.
    pub half_angle: f32,
    /// Distance from the apex at which the cone ends, metres. It may be infinite.
    pub range: f32,
}

impl Cone {
    /// How far the cone reaches from its apex along a unit vector, metres; at least 0. Exact except for
    /// rounding, which stays below a millionth of the range.
    pub fn extent(&self, direction: Vec3) -> f32 {
        let angle = direction.dot(self.axis).clamp(-1.0, 1.0).acos();
        let beyond = (angle - self.half_angle).max(0.0);
        // `acos` is wrong by up to 4e-4 rad near 0 and π. With a finite range the cosine hardly shows it.
        // With an infinite range the error would decide between everything and nothing.
        if self.range == f32::INFINITY {
            let reaches = beyond < std::f32::consts::FRAC_PI_2 + 1e-3;
            return if reaches { f32::INFINITY } else { 0.0 };
        }
        self.range * beyond.cos().max(0.0)
    }

    /// The box around the cone. It is infinite on the sides towards which an infinite cone opens.
    pub fn aabb(&self) -> Aabb {
        let reach = |direction: Vec3| self.extent(direction);
        // `acos` loses half its digits near 0 and π. The pad exceeds the resulting error of the cosine.
        let pad = |length: f32| {
            length * (1.0 + 1e-6) + 1e-6 * if self.range.is_finite() { self.range } else { 0.0 }
        };
        Aabb {
            min: self.apex - Vec3::from_array([Vec3::X, Vec3::Y, Vec3::Z].map(|axis| pad(reach(-axis)))),
            max: self.apex + Vec3::from_array([Vec3::X, Vec3::Y, Vec3::Z].map(|axis| pad(reach(axis)))),
        }
    }

    /// Homogeneous corners of a pyramid around the cone, apex first. The pyramid is oriented along the axis,
    /// so for a narrow cone it is tighter than [`Cone::aabb`]. An infinite range gives directions (`w = 0`).
    /// `None` for half-angles above 1.2 rad, where the pyramid's base is so wide that it bounds nothing.
    pub fn bounding_points(&self) -> Option<[DVec4; 5]> {
        if self.half_angle > 1.2 {
            return None;
        }
        let (apex, axis) = (self.apex.as_dvec3(), self.axis.as_dvec3());
        let (x, y) = axis.any_orthonormal_pair();
        // The slope is enlarged by more than the rounding of `axis` and of the angle, both `f32`.
        let slope = f64::from(self.half_angle).tan() * (1.0 + 1e-5) + 1e-6;
        let mut points = [apex.extend(1.0); 5];
        let signs = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        for (point, (sx, sy)) in points[1..].iter_mut().zip(signs) {
            let ray = axis + (x * sx + y * sy) * slope;
            *point = if self.range.is_finite() {
                (apex + ray * (f64::from(self.range) * (1.0 + 1e-5))).extend(1.0)
            } else {
                ray.extend(0.0)
            };
        }
        Some(points)
    }

    /// Whether the box lies wholly outside the cone. Conservative: `false` for some boxes that miss the cone,
    /// never `true` for a box that touches it.
    ///
    /// Three tests, each exact for its own convex bound: the ball of the range, the half-space in front of
    /// the apex, and the tangent plane of the cone that faces the box's centre. A box near the place where
    /// two of these bounds meet may miss the cone and still pass all three.
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
