//! The face of a spot light's map.

use glam::DVec3;

use super::cube::GUARD_TEXELS;
use super::face::{FaceProjection, MapFace};
use super::settings::MapFilter;
use crate::sets::FrameLight;

/// Returns the unit axis of a spot light's picture, and half the picture's side at distance 1. The picture holds all that
/// the light lights and what the filter reaches beside it, as seen from the place of the light's shadows. `None` for
/// lights of other kinds.
pub fn spot_picture(light: &FrameLight, filter: MapFilter) -> Option<(DVec3, f64)> {
    let (axis, half_angle) = light.shadow_cone()?;
    let rim = half_angle.tan();
    let softness = f64::from(filter.softness().unwrap_or(0.0));
    Some((axis, rim + softness * (1.0 + rim * rim).sqrt()))
}

/// Returns the face of a spot light, which shows its picture and some texels around it.
pub fn spot_face(light: &FrameLight, filter: MapFilter, near: f64, resolution: u32) -> Option<MapFace> {
    let (z, tangent) = spot_picture(light, filter)?;
    let (x, y) = z.any_orthonormal_pair();
    let resolution = f64::from(resolution);
    let guard = f64::from(GUARD_TEXELS).min(0.25 * resolution);
    let tangent = tangent * resolution / (resolution - 2.0 * guard);
    Some(MapFace {
        origin: light.point_world.truncate(),
        axes: [x, y, z],
        projection: FaceProjection::Perspective { tangent, near },
    })
}
