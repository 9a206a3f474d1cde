//! Limits the size of maps to the size that the device allows.

use bevy_ecs::prelude::*;

use crate::render::Renderer;
use crate::techniques::maps::MapSettings;

/// Lowers [`MapSettings::largest`] to the largest texture that the device allows.
///
/// Set: `BuildTechniques`, before `ask_for_maps`.
pub fn limit_to_device(renderer: Res<Renderer>, mut settings: ResMut<MapSettings>) {
    let limit = renderer.context().device.limits().max_texture_dimension_2d;
    if settings.largest > limit {
        settings.largest = limit;
    }
}
