//! Holds maps to the size that the device allows.

use bevy_ecs::prelude::*;

use crate::render::Renderer;
use crate::techniques::maps::MapSettings;

/// Lowers [`MapSettings::largest`] to what the device allows.
///
/// Set: `BuildTechniques`, before `build_maps`.
pub fn limit_to_device(renderer: Res<Renderer>, mut settings: ResMut<MapSettings>) {
    let limit = renderer.context().device.limits().max_texture_dimension_2d;
    if settings.largest > limit {
        settings.largest = limit;
    }
}
