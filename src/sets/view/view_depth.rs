//! How far the depth of a view reaches.

use std::sync::atomic::{AtomicU64, Ordering};

use bevy_ecs::prelude::*;

use super::frame_view::View;
use super::screen::Projector;
use super::stored_depth::ViewDepth;
use super::visible::VisibleSet;
use crate::sets::index::objects::Objects;
use crate::sets::light::frame_lights::FrameLights;

/// How deep techniques draw into an orthographic view. Its shadow volumes end at a finite depth, and none may
/// be cut off there, because its end counts at surfaces in front of it. Perspective views reach infinity and
/// do not need this.
///
/// Techniques share it while they run, in any order: the greatest depth does not depend on who comes first.
#[derive(Resource, Debug, Default)]
pub struct DepthReach {
    /// [`ordered`] bits of the farthest depth; 0 if nothing is drawn. Depth 0 does not stand for that, because all of an
    /// orthographic view may lie at negative depth.
    farthest: AtomicU64,
}

/// The sign bit of an `f64`.
const SIGN: u64 = 1 << 63;

/// Bits that order as the depths do, negative ones too. They are greater than 0 for all depths.
fn ordered(depth: f64) -> u64 {
    let bits = depth.to_bits();
    if bits & SIGN == 0 { bits | SIGN } else { !bits }
}

/// The depth of [`ordered`] bits.
fn depth_of(bits: u64) -> f64 {
    f64::from_bits(if bits & SIGN == 0 { !bits } else { bits & !SIGN })
}

impl DepthReach {
    /// Records that something is drawn as deep as `depth` in this frame.
    pub fn include(&self, depth: f64) {
        if !depth.is_nan() {
            self.farthest.fetch_max(ordered(depth), Ordering::Relaxed);
        }
    }

    /// The farthest depth that something is drawn at; −∞ if there is none.
    pub fn farthest(&self) -> f64 {
        match self.farthest.load(Ordering::Relaxed) {
            0 => f64::NEG_INFINITY,
            bits => depth_of(bits),
        }
    }

    fn reset(&self) {
        self.farthest.store(0, Ordering::Relaxed);
    }
}

/// Resets [`DepthReach`], as nothing is drawn yet.
///
/// Set: `CollectSets`, first.
pub fn begin_depth_reach(reach: Res<DepthReach>) {
    reach.reset();
}

/// Sizes an orthographic view's depth range so that it holds everything drawn this frame: visible objects up
/// to the far plane, and what techniques have added to [`DepthReach`].
///
/// Set: `PrepareGpu`, first. Writes the depth range, the matrices and the stored depth bounds of lights. The
/// length of the range is a power of two, so that it rarely changes. Cost: the visible objects.
pub fn fit_view_depth(
    mut view: ResMut<View>,
    mut lights: ResMut<FrameLights>,
    reach: Res<DepthReach>,
    objects: Res<Objects>,
    visible: Res<VisibleSet>,
) {
    let is_orthographic = |view: &View| {
        view.data
            .as_ref()
            .is_some_and(|data| data.frustum.far().is_some())
    };
    if !is_orthographic(&view) {
        return;
    }
    let Some(current) = &view.data else {
        return;
    };
    let (near, plane) = (current.near, current.frustum.far().unwrap_or(current.near));
    let projector = Projector::new(current);
    let gradient = projector.depth_gradient().abs();
    let deepest = visible
        .set
        .ones()
        .map(|object| {
            let (center, half) = objects.boxes.center_half(object);
            projector.depth(center) + gradient.dot(half)
        })
        .fold(near, f64::max);
    let needed = deepest.min(plane).max(reach.farthest());
    // The range is a little longer than needed, so that its end can be distinguished from the background
    // behind it.
    let length = ((needed - near) * 1.001)
        .max(1e-3 * (plane - near))
        .log2()
        .ceil()
        .exp2();
    let depth = ViewDepth::Finite {
        near,
        far: near + length,
    };
    if current.depth == depth {
        return;
    }
    if let Some(current) = &mut view.bypass_change_detection().data {
        current.set_depth(depth);
    }
    for light in &mut lights.bypass_change_detection().lights {
        light.region.depth_bounds = light.region.depth_bounds.map(|bounds| bounds.stored_in(depth));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_greatest_reach_counts_in_any_order() {
        let reach = DepthReach::default();
        for depth in [3.0, f64::NAN, 70.0, -80.0, 5.0] {
            reach.include(depth);
        }
        assert_eq!(reach.farthest(), 70.0);
        reach.reset();
        assert_eq!(reach.farthest(), f64::NEG_INFINITY);
        for depth in [-80.0, -3.0, -5.0] {
            reach.include(depth);
        }
        assert_eq!(reach.farthest(), -3.0);
    }
}
