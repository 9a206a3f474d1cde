//! The pictures that together show everything that a light sees.

use glam::DVec3;
use smallvec::SmallVec;

use super::projection::Projection;
use crate::geometry::Aabb;
use crate::scene::LightKind;
use crate::sets::FrameLight;

/// Largest half-angle of a spot light's cone that fits into a single picture, radians.
const ONE_PICTURE: f32 = 1.0;

/// Distance from a light below which occluders hide nothing, metres. For ranges below 1 m it is this share of
/// the range.
const NEAR: f64 = 1e-3;

/// How much wider a spot light's picture is than its cone, so that bounds on the rim are in the picture
/// despite rounding.
const RIM: f64 = 1.01;

/// The pictures of a light, of everything within `bounds`: six cube faces around a point, one picture along
/// the axis of a spot light, or one parallel picture for a directional light. There is none for a light with
/// an extent, because one of its points may see what another does not.
pub fn light_views(light: &FrameLight, bounds: &Aabb, width: u32) -> SmallVec<[Projection; 6]> {
    if light.emitter.bounding_radius() > 0.0 || bounds.is_empty() {
        return SmallVec::new();
    }
    let eye = light.point_world.truncate();
    let axes = |forward: DVec3| {
        let (right, up) = forward.any_orthonormal_pair();
        [right, up, forward]
    };
    let near = NEAR.min(f64::from(light.light.range) * NEAR);
    match light.light.kind {
        LightKind::Directional => {
            let axes = axes(-eye.normalize());
            SmallVec::from_slice(&[Projection::parallel(bounds, axes, width)])
        }
        LightKind::Spot { outer_angle, .. } if outer_angle <= ONE_PICTURE => {
            let tan = f64::from(outer_angle).tan() * RIM + 1e-3;
            let axes = axes(light.direction.as_dvec3().normalize());
            SmallVec::from_slice(&[Projection::perspective(eye, axes, tan, near, width)])
        }
        _ => [DVec3::X, DVec3::Y, DVec3::Z]
            .into_iter()
            .flat_map(|axis| [axis, -axis])
            .map(|axis| Projection::perspective(eye, axes(axis), 1.0, near, width))
            .collect(),
    }
}
