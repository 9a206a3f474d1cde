//! How the depth of a view is stored, and how far it reaches.

use bevy_ecs::prelude::*;

use super::frame_view::View;
use super::screen::Projector;
use super::visible::VisibleSet;
use crate::sets::index::objects::Objects;
use crate::sets::light::frame_lights::FrameLights;

/// Reversed depth: 1 on the near plane, 0 at the far end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewDepth {
    /// `near / depth`: of a perspective view.
    Infinite {
        /// View depth of the near plane, > 0.
        near: f64,
    },
    /// Linear between the two: of an orthographic view.
    Finite {
        /// View depth that is stored as 1.
        near: f64,
        /// View depth that is stored as 0; greater.
        far: f64,
    },
}

impl ViewDepth {
    /// View depth of the near plane.
    pub fn near(self) -> f64 {
        match self {
            Self::Infinite { near } | Self::Finite { near, .. } => near,
        }
    }

    /// What is stored for a view depth.
    pub fn stored(self, depth: f64) -> f64 {
        match self {
            Self::Infinite { near } => near / depth,
            Self::Finite { near, far } => (far - depth) / (far - near),
        }
    }

    /// By how much stored depth may err, of a surface at a view depth, if `f32` errs by this share.
    pub fn stored_slack(self, depth: f64, share: f64) -> f64 {
        match self {
            Self::Infinite { near } => near / depth * share,
            Self::Finite { .. } => share, // of 1, from which the depths are subtracted
        }
    }

    /// The same of a view depth.
    pub fn slack(self, depth: f64, share: f64) -> f64 {
        match self {
            Self::Infinite { .. } => depth.abs() * share,
            Self::Finite { near, far } if depth.is_finite() => (near.abs() + far.abs()) * share,
            Self::Finite { .. } => 0.0,
        }
    }
}

/// How far techniques draw into the depth of an orthographic view. Shadow volumes end there at a finite depth, and none
/// may be cut off: it counts at surfaces before it. Perspective views reach infinity, and have no use for this.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct DepthReach {
    farthest: f64,
}

impl Default for DepthReach {
    /// Nothing is drawn. Not 0: all of an orthographic view may lie at negative depth.
    fn default() -> Self {
        Self {
            farthest: f64::NEG_INFINITY,
        }
    }
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
