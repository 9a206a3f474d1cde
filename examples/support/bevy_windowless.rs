//! Plugins and pictures for Bevy games without a window.

use bevy::app::PluginGroupBuilder;
use bevy::asset::RenderAssetUsages;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::window::ExitCondition;

/// Returns Bevy's plugins without a window. A frame waits for its pipelines.
pub fn plugins() -> PluginGroupBuilder {
    let plugins = DefaultPlugins
        .set(WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..default()
        })
        .set(RenderPlugin {
            synchronous_pipeline_compilation: true,
            ..default()
        });
    #[cfg(feature = "bevy-window")]
    let plugins = plugins.disable::<bevy::winit::WinitPlugin>();
    plugins
}

/// Creates a picture to render into and to read back.
pub fn picture(world: &mut World, size: UVec2) -> Handle<Image> {
    let mut picture = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba8UnormSrgb, None);
    picture.asset_usage = RenderAssetUsages::RENDER_WORLD;
    picture.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    world.resource_mut::<Assets<Image>>().add(picture)
}
