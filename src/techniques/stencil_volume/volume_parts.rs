//! Which parts of a caster's volume can matter.
//!
//! | part | left out |
//! | --- | --- |
//! | sides | their bounds miss the view frustum |
//! | near cap | depth-pass (it lies on the caster's own, drawn surface), or the caster's bounds miss the frustum |
//! | far cap | directional light to infinity (all far corners are one point), depth-pass to infinity (nothing is behind infinity), or its bounds miss the frustum; depth-pass too where nothing lit lies behind it, or nothing of it is seen |
//!
//! A finite volume keeps its far cap under depth-pass else: a pixel inside the light's range may be seen through it. In an
//! orthographic view all volumes are finite ([`finite_reach`](crate::techniques::shared::finite_reach)).
//! Source: McGuire 2004, GPU Gems ch. 9, sections 9.5.1 to 9.6.1.

use glam::{DVec3, Vec4};

use super::caster_volume::CasterVolume;
use crate::geometry::{Aabb, excludes_points};
use crate::sets::light::depth_bounds::shadow_depth_range;
use crate::sets::occlusion::Viewpoint;
use crate::sets::{FrameLight, Projector, ViewData};
use crate::techniques::shared::extrude::TO_INFINITY;

/// What parts of the volumes in one light are asked against.
#[derive(Debug)]
pub struct PartCulling<'a> {
    light: &'a FrameLight,
    view: &'a ViewData,
    projector: Projector,
    before_camera: &'a Viewpoint,
}

impl<'a> PartCulling<'a> {
    /// Of a light in a view; `before_camera` is what stands before the camera, or nothing.
    pub fn new(light: &'a FrameLight, view: &'a ViewData, before_camera: &'a Viewpoint) -> Self {
        Self {
            light,
            view,
            projector: Projector::new(view),
            before_camera,
        }
    }

    /// Drops parts that cannot matter; `None` if none is left. `corners` are those of the volume, `bounds` those of the
    /// caster, world space.
    pub fn cull(
        &self,
        mut volume: CasterVolume,
        corners: &[Vec4; 16],
        bounds: &Aabb,
    ) -> Option<CasterVolume> {
        let light = self.light;
        let to_infinity = volume.extrusion == TO_INFINITY;
        let (near_corners, far_corners) = corners.split_at(8);
        let is_seen = |points: &[Vec4]| !excludes_points(self.view.frustum.open_planes(), points);
        volume.sides = is_seen(corners);
        volume.near_cap &= is_seen(near_corners);
        // At infinity a directional light's far cap is one point, and behind any there is nothing to count towards the viewer.
        let has_far_cap = !to_infinity || (light.point_world.w != 0.0 && !volume.depth_pass);
        volume.far_cap =
            has_far_cap && is_seen(far_corners) && !(volume.depth_pass && self.hides(far_corners));
        if !(volume.sides || volume.near_cap || volume.far_cap) {
            return None;
        }
        // A volume that ends before the nearest, or begins beyond the farthest surface that the light reaches, counts to 0
        // at all of them.
        let reached = light.depth_bounds?;
        let spanned = shadow_depth_range(self.view, bounds, &light.emitter)?;
        spanned.intersects(&reached).then_some(volume)
    }

    /// Whether all that the light reaches in view lies before the hull of these positions, or something else does.
    fn hides(&self, corners: &[Vec4]) -> bool {
        let corners = || corners.iter().map(|corner| corner.truncate().as_dvec3());
        let nearest = corners()
            .map(|corner| self.projector.depth(corner))
            .fold(f64::INFINITY, f64::min);
        if self
            .light
            .depth_bounds
            .is_some_and(|reached| nearest > f64::from(reached.far))
        {
            return true;
        }
        let min = corners().fold(DVec3::INFINITY, DVec3::min);
        let max = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        self.before_camera.hides_box((min + max) * 0.5, (max - min) * 0.5)
    }
}
