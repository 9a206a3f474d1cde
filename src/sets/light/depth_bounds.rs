//! Depth bounds: the range of view depth that a light, or the shadow of a caster, can reach.

use glam::DVec3;

use crate::geometry::{Aabb, Emitter};
use crate::sets::view::frame_view::ViewData;
use crate::sets::view::screen::{Projector, ScreenBounds};
use crate::sets::view::stored_depth::ViewDepth;

/// A range of view depth. A pixel whose surface lies outside it is neither lit nor shadowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthBounds {
    /// Smallest view depth, at least that of the near plane (less the slack for rounding).
    pub near: f32,
    /// Largest view depth. It may be infinite.
    pub far: f32,
    /// Reversed depth value of `far`, which is the smallest value inside; 0 for infinity.
    pub depth_min: f32,
    /// Reversed depth value of `near`, which is the largest value inside; at most 1.
    pub depth_max: f32,
}

/// Share by which ranges grow at both ends. The GPU computes depth in `f32`, with some ten roundings of 2⁻²⁴.
const SLACK: f64 = 4e-6;

impl DepthBounds {
    /// The range, cut at the near plane and grown by as much as rounding can lose. `None` if it is empty.
    pub fn around(near: f64, far: f64, depth: ViewDepth) -> Option<Self> {
        let near = near.max(depth.near());
        if near > far || far.is_nan() {
            return None;
        }
        let (near, far) = (near - depth.slack(near, SLACK), far + depth.slack(far, SLACK));
        Some(Self::stored(near, far, depth))
    }

    fn stored(near: f64, far: f64, depth: ViewDepth) -> Self {
        let (at_near, at_far) = (depth.stored(near), depth.stored(far));
        Self {
            near: near as f32,
            far: far as f32,
            depth_min: (at_far - depth.stored_slack(far, SLACK)).max(0.0) as f32,
            depth_max: (at_near + depth.stored_slack(near, SLACK)).min(1.0) as f32,
        }
    }

    /// Returns this range of view depth with the stored values of another mapping of depth.
    pub(in crate::sets) fn stored_in(self, depth: ViewDepth) -> Self {
        Self::stored(f64::from(self.near), f64::from(self.far), depth)
    }

    /// The depth range of screen bounds. `None` if it is empty.
    pub(in crate::sets) fn of_screen(bounds: &ScreenBounds, depth: ViewDepth) -> Option<Self> {
        Self::around(bounds.near, bounds.far, depth)
    }

    /// Whether the two ranges share a depth.
    pub fn intersects(&self, other: &Self) -> bool {
        self.near <= other.far && other.near <= self.far
    }
}

/// Range of view depth of a caster's shadow volume: the caster's box, extruded away from the whole light to
/// infinity. `None` if all of it lies in front of the near plane, or the box is empty. A caster whose range
/// misses the light's [`DepthBounds`] shadows nothing that the light lights.
///
/// A corner `v` of the box goes to infinity in direction `v · L.w − L.xyz`. View depth is linear, so the
/// range ends at a corner, or at infinity if such a direction leads deeper.
/// Source: McGuire 2004, "Efficient Shadow Volume Rendering", GPU Gems ch. 9, §9.5.3 and §9.6.3.
pub fn shadow_depth_range(view: &ViewData, caster: &Aabb, light: &Emitter) -> Option<DepthBounds> {
    if caster.is_empty() {
        return None;
    }
    let projector = Projector::new(view);
    let gradient = projector.depth_gradient();
    let caster = caster.padded();
    let (mut near, mut far) = (f64::INFINITY, f64::NEG_INFINITY);
    let length = gradient.length();
    let extent = if length > 0.0 {
        light.extent(gradient / length) * length
    } else {
        0.0
    };
    for corner in caster.corners() {
        let corner = corner.as_dvec3();
        let depth = projector.depth(corner);
        near = near.min(depth);
        far = far.max(depth);
        let away: DVec3 = corner * light.point.w - light.point.truncate();
        let slope = gradient.dot(away);
        // The light's extent turns the direction by as much as it moves the light.
        if slope + extent > 0.0 {
            far = f64::INFINITY;
        }
        if slope - extent < 0.0 {
            near = f64::NEG_INFINITY;
        }
    }
    DepthBounds::around(near, far, view.depth)
}
