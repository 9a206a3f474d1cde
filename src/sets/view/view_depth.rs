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
    /// Bits of the farthest depth, an `f64`, at least 0. Such numbers order as their bits do.
    farthest: AtomicU64,
}

impl DepthReach {
    /// Records that something is drawn as deep as `depth` in this frame.
    pub fn include(&self, depth: f64) {
        if depth > 0.0 {
            self.farthest.fetch_max(depth.to_bits(), Ordering::Relaxed);
        }
    }

    /// The farthest depth that something is drawn at; 0 if there is none.
    pub fn farthest(&self) -> f64 {
        f64::from_bits(self.farthest.load(Ordering::Relaxed))
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
        light.depth_bounds = light.depth_bounds.map(|bounds| bounds.stored_in(depth));
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
        assert_eq!(reach.farthest(), 0.0);
    }
}
