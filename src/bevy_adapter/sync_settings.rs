//! Copies the settings that the game has as resources to the mirrors.
//!
//! [`LightClearance`](crate::sets::LightClearance),
//! [`OcclusionSettings`](crate::sets::OcclusionSettings),
//! [`MapSettings`](crate::techniques::maps::MapSettings) and
//! [`IntervalFolder`](crate::techniques::IntervalFolder) are resources of the world that the techniques run in.
//! In a game each marked camera has such a world. The game inserts the resource in its own world, and all
//! cameras follow it. Without the resource they have its default.

use bevy::ecs::prelude::*;
use bevy::render::Extract;

use super::mirror::Mirrors;

/// Copies a setting to the mirrors when it was inserted or changed, and to mirrors that are new. When the game
/// removes the setting, the mirrors get its default.
///
/// Runs in `ExtractSchedule`. Set: [`Sync`](super::AntumbraExtractSystems::Sync).
pub(super) fn sync_setting<S: Resource + Clone + Default>(
    mut mirrors: ResMut<Mirrors>,
    setting: Extract<Option<Res<S>>>,
    mut has_setting: Local<bool>,
) {
    let had_setting = std::mem::replace(&mut *has_setting, setting.is_some());
    for mirror in mirrors.iter_mut() {
        match &*setting {
            Some(setting) if mirror.fresh || setting.is_changed() => {
                mirror.world.insert_resource(S::clone(setting));
            }
            None if had_setting => mirror.world.insert_resource(S::default()),
            _ => {}
        }
    }
}
