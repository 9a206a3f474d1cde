//! The region of space that a light lights.

use glam::{DVec3, DVec4};

use super::light_volume::LightVolume;
use super::placing::Shining;
use crate::geometry::{Aabb, Pyramid};
use crate::scene::LightModel;
use crate::sets::view::screen::{Projector, ScreenBounds};

/// The region of space that a light lights. It is a part of the light's volume, which also holds the place from
/// which the light's shadows are cast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitRegion {
    /// The region, without its barn doors.
    pub volume: LightVolume,
    /// Corners of the pyramid between the barn doors.
    corners: Option<[DVec4; 5]>,
    /// Box around that pyramid.
    aabb: Option<Aabb>,
    near: Option<Near>,
}

/// The part of space that is too near to a light to be lit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Near {
    /// Depth before which nothing is lit, metres.
    depth: f64,
    center: DVec3,
    /// Direction along which depth is measured; `None` if it is the distance from the centre.
    along: Option<DVec3>,
}

/// Share of its depth by which the near end is moved towards the light. It covers rounding.
const SLACK: f64 = 1e-5;

impl LitRegion {
    /// The region of a light, from its volume, its barn doors and its distances.
    pub(super) fn new(
        volume: LightVolume,
        doors: Option<&Pyramid>,
        model: &LightModel,
        shining: &Shining,
    ) -> Self {
        let [.., along] = shining.axes;
        let near = model
            .distance
            .filter(|distance| distance.near > distance.near_edge);
        Self {
            volume,
            corners: doors.and_then(Pyramid::corners),
            aabb: doors.and_then(Pyramid::aabb),
            near: near.map(|distance| Near {
                depth: f64::from(distance.near - distance.near_edge) * (1.0 - SLACK) - SLACK,
                center: shining.emitter.point.truncate(),
                along: doors.is_some().then_some(along),
            }),
        }
    }

    /// The box around the region, padded. It is infinite where the region is.
    pub fn aabb(&self) -> Aabb {
        let volume = self.volume.aabb();
        self.aabb.map_or(volume, |doors| doors.intersection(volume))
    }

    /// Bounds on the screen of the part of the region that lies behind the near plane of the view.
    pub(in crate::sets) fn screen_bounds(&self, projector: &Projector) -> ScreenBounds {
        let bounds = self.volume.screen_bounds(projector);
        match self.corners {
            Some(corners) => bounds.intersection(projector.bounds_of_hull(corners)),
            None => bounds,
        }
    }

    /// Whether some box can be too near to the light.
    pub(in crate::sets) fn has_near(&self) -> bool {
        self.near.is_some()
    }

    /// Whether every point of the box is too near to the light to be lit.
    pub(in crate::sets) fn is_too_near(&self, aabb: &Aabb) -> bool {
        self.near.is_some_and(|near| {
            let to_center = aabb.center().as_dvec3() - near.center;
            let half = aabb.half_size().as_dvec3();
            let farthest = match near.along {
                Some(along) => along.dot(to_center) + along.abs().dot(half),
                None => (to_center.abs() + half).length(),
            };
            farthest < near.depth
        })
    }
}
