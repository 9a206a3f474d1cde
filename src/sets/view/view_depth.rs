//! How far the depth of a view reaches.

use bevy_ecs::prelude::*;

use super::frame_view::View;
use super::screen::Projector;
use super::stored_depth::ViewDepth;
use super::visible::VisibleSet;
use crate::sets::index::objects::Objects;
use crate::sets::light::frame_lights::FrameLights;

/// How far techniques draw into the depth of an orthographic view. Shadow volumes end there at a finite depth, and none
/// may be cut off: it counts at surfaces before it. Perspective views reach infinity, and have no use for this.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct DepthReach {
    farthest: f64,
}

impl DepthReach {
    /// Something of this frame is drawn so deep.
    pub fn include(&mut self, depth: f64) {
        self.farthest = self.farthest.max(depth);
    }
}

/// Nothing has been drawn yet.
///
/// Set: `CollectSets`, first.
pub fn begin_depth_reach(mut reach: ResMut<DepthReach>) {
    reach.set_if_neq(DepthReach::default());
}

/// Gives an orthographic view the depth that all reaches which is drawn in this frame: visible objects up to the far
/// plane, and what techniques have told of.
///
/// Set: `PrepareGpu`, first. Writes the depth, the matrices and the stored depth bounds of lights. The depth grows in
/// steps of two, so that it mostly stays as it is. Cost: the visible objects.
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
    let needed = deepest.min(plane).max(reach.farthest);
    // A little more, so that the end itself is told from what is behind it.
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
