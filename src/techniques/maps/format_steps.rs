//! Distances from a light that the bytes of its map's format cannot tell apart.

use super::light_map::LightMap;
use super::packing::{FOUR_BYTES_STEP, TWO_BYTES_STEP};
use super::settings::MapFormat;
use crate::geometry::Aabb;
use crate::sets::FrameLight;

/// Distance within which steps are long, in lengths of the distance whose square is one step. At its end, a step is an
/// eighth of it.
const LONG_STEPS: f64 = 2.0;

/// Returns the distance from the light, metres, within which the steps of the map's format are long, if at least half of the
/// visible receivers are wholly within it.
pub fn coarse_distance(map: &LightMap, light: &FrameLight) -> Option<f64> {
    let step = match map.request.format {
        MapFormat::Rgba8TwoBytes => TWO_BYTES_STEP,
        MapFormat::Rgba8FourBytes => FOUR_BYTES_STEP,
        MapFormat::Depth | MapFormat::R32Float => return None,
    };
    let distance = LONG_STEPS * map.reach * f64::from(step).sqrt();
    let point = light.point_world.truncate();
    let is_within = |receiver: &&Aabb| {
        let offset = (receiver.center().as_dvec3() - point).abs() + receiver.half_size().as_dvec3();
        offset.length() < distance
    };
    let receivers = &light.region.lit_receivers;
    let within = receivers.iter().filter(is_within).count();
    (within > 0 && 2 * within >= receivers.len()).then_some(distance)
}
