//! Circular cone with a spherical end: what a spot light reaches.

use glam::Vec3;

/// A cone from `apex` along `axis` up to `range` from the apex.
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
