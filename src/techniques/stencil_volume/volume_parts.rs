//! Which parts of a caster's volume can matter.
//!
//! | part | left out |
//! | --- | --- |
//! | sides | their bounds miss the view frustum; then the caps do, too, and there is no volume |
//! | near cap | depth-pass (it lies on the caster's own, drawn surface), or the caster's bounds miss the frustum |
//! | far cap | directional light to infinity (all far corners are one point), depth-pass to infinity (nothing is behind infinity), or its bounds miss the frustum; with depth-pass also where it is behind all that is lit, or hidden by occluders |
//!
//! Otherwise a finite volume keeps its far cap with depth-pass, because a pixel inside the light's range may
//! be seen through the cap. In an orthographic view all volumes are finite
//! ([`finite_reach`](crate::techniques::shared::finite_reach)).
//! Source: McGuire 2004, GPU Gems ch. 9, sections 9.5.1 to 9.6.1.

use glam::{DVec3, Vec4};

use super::caster_volume::CasterVolume;
use crate::geometry::{Aabb, excludes_points};
use crate::sets::light::depth_bounds::shadow_depth_range;
use crate::sets::occlusion::Viewpoint;
use crate::sets::{FrameLight, Projector, ViewData};
use crate::techniques::shared::extrude::TO_INFINITY;

/// Decides for one light which parts of its volumes can matter.
#[derive(Debug)]
pub struct PartCulling<'a> {
    light: &'a FrameLight,
    view: &'a ViewData,
    projector: Projector,
    before_camera: &'a Viewpoint,
}

impl<'a> PartCulling<'a> {
    /// Makes the test for a light in a view. `before_camera` holds the occluders in front of the camera, if
    /// there are any.
    pub fn new(light: &'a FrameLight, view: &'a ViewData, before_camera: &'a Viewpoint) -> Self {
        Self {
            light,
            view,
            projector: Projector::new(view),
            before_camera,
        }
    }

    /// Drops parts that cannot matter; `None` if the whole volume cannot. `corners` are those of the volume and `bounds`
    /// those of the caster, in world space.
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
        if !is_seen(corners) {
            return None;
        }
        volume.near_cap &= is_seen(near_corners);
        // The far cap of a directional light at infinity is one point. Depth-pass counts nothing behind
        // infinity.
        let has_far_cap = !to_infinity || (light.point_world.w != 0.0 && !volume.depth_pass);
        volume.far_cap =
            has_far_cap && is_seen(far_corners) && !(volume.depth_pass && self.hides(far_corners));
        // A volume that ends in front of the nearest surface that the light reaches, or begins behind the
        // farthest, counts to 0 at all of them.
        let reached = light.region.depth_bounds?;
        let spanned = shadow_depth_range(self.view, bounds, &light.emitter)?;
        spanned.intersects(&reached).then_some(volume)
    }

    /// Whether the hull of these positions is behind all surfaces that the light reaches in view, or hidden
    /// by occluders.
    fn hides(&self, corners: &[Vec4]) -> bool {
        let corners = || corners.iter().map(|corner| corner.truncate().as_dvec3());
        let nearest = corners()
            .map(|corner| self.projector.depth(corner))
            .fold(f64::INFINITY, f64::min);
        if self
            .light
            .region
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
