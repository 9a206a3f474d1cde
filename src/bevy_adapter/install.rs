//! Registration of the adapter in a Bevy app, called by [`AntumbraPlugin`](crate::plugin::AntumbraPlugin).

use bevy::app::{App, Last, PostUpdate, SubApp};
use bevy::asset::{AssetEventSystems, AssetPlugin, Assets};
use bevy::core_pipeline::CorePipelinePlugin;
use bevy::core_pipeline::core_3d::{
    AlphaMask3d, Opaque3d, check_msaa, main_opaque_pass_3d, prepare_prepass_textures,
};
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass};
use bevy::core_pipeline::schedule::{Core3d, Core3dSystems};
use bevy::ecs::prelude::*;
use bevy::pbr::deferred::{DeferredLightingLayout, deferred_lighting, prepare_deferred_lighting_pipelines};
use bevy::pbr::{
    MeshPipelineSystems, PbrPlugin, queue_material_meshes, queue_prepass_material_meshes,
    screen_space_reflections,
};
use bevy::render::render_phase::AddRenderCommand;
use bevy::render::{ExtractSchedule, Render, RenderApp, RenderStartup, RenderSystems};
use bevy::shader::Shader;
use bevy::transform::TransformSystems;

use super::camera::{AntumbraCamera, keep_msaa_off, put_back};
use super::camera_warnings::{warn_of_marked, warn_of_unmarked, warn_without_renderer};
use super::cut_outs::CutOutCasters;
use super::deferral::{Deferral, collect_methods, tell_of_forward};
use super::deferred_views::{DeferredViews, collect_deferred_views, queue_deferred};
use super::forward_shaders::{ForwardShaders, collect_reloaded, extend_shaders};
use super::forward_views::{DrawShadowed, ForwardViews};
use super::mesh_library::{MeshLibrary, collect_meshes};
use super::mirror::Mirrors;
use super::pass::light_view;
use super::pipelines::{AntumbraShaders, init_pipelines};
use super::prepare::prepare_views;
use super::ranges::sync_levels;
use super::refused::RefusedMeshes;
use super::report::{LightlessTechniques, publish_reports};
use super::settings::AntumbraSettings;
use super::shared_targets::separate_prepass_textures;
use super::surfaces::{Surfaces, collect_surfaces};
use super::sync::{end_sync, sync_cameras, sync_texture_memory, sync_transforms};
use super::sync_cells::sync_cells;
use super::sync_lights::sync_lights;
use super::sync_models;
use super::sync_objects::sync_objects;
use super::sync_settings::sync_setting;
use super::systems::{AntumbraExtractSystems, AntumbraMainSystems, AntumbraRenderSystems, Installed};
use super::techniques::{Reflected, TechniqueComponents, add_waiting};
use crate::reports::Reports;
use crate::scene::LightSelection;
use crate::sets::{LightClearance, OcclusionSettings};
use crate::techniques::IntervalFolder;
use crate::techniques::add_builtin;
use crate::techniques::maps::MapSettings;
use crate::techniques::occlusion_interval::component::follow_light_paths;

/// Registers types, and adds the system that an app without a renderer needs. Every app gets these.
pub fn register(app: &mut App) {
    app.register_type::<AntumbraCamera>()
        .register_type::<LightSelection>()
        .register_type::<crate::scene::BlurredGround>()
        .register_type::<LightClearance>()
        .add_systems(
            Last,
            warn_without_renderer.run_if(not(resource_exists::<Installed>)), // no renderer shows shadows
        );
    sync_models::register(app);
    add_builtin(&mut Reflected(app));
}

/// Installs the adapter if the app has Bevy's renderer of 3D scenes. Returns `false` if the app does not have
/// it (yet).
pub fn install(app: &mut App) -> bool {
    if app.world().contains_resource::<Installed>() {
        return true;
    }
    // Both plugins add schedules and resources that the adapter needs.
    let renders = app.is_plugin_added::<CorePipelinePlugin>() && app.is_plugin_added::<PbrPlugin>();
    if !renders || app.get_sub_app(RenderApp).is_none() {
        return false;
    }
    let interval_folder = asset_folder(app);
    app.insert_resource(Installed)
        .init_resource::<AntumbraSettings>()
        .init_resource::<MeshLibrary>()
        .init_resource::<Reports>()
        .init_resource::<TechniqueComponents>()
        .insert_resource(interval_folder)
        .add_observer(put_back::<DepthPrepass>)
        .add_observer(put_back::<DeferredPrepass>)
        .add_systems(
            PostUpdate,
            (keep_msaa_off.before(check_msaa), warn_of_marked, warn_of_unmarked)
                .in_set(AntumbraMainSystems::CheckCameras),
        )
        .add_systems(Last, keep_msaa_off)
        .add_systems(PostUpdate, follow_light_paths.before(TransformSystems::Propagate))
        .add_systems(
            PostUpdate,
            collect_meshes
                .in_set(AntumbraMainSystems::CollectMeshes)
                .after(AssetEventSystems),
        );
    add_builtin(app);
    add_waiting(app);
    sync_models::watch(app);
    let shaders = AntumbraShaders::add(&mut app.world_mut().resource_mut::<Assets<Shader>>());
    let render_app = app.sub_app_mut(RenderApp);
    render_app.insert_resource(shaders);
    add_render_resources(render_app);
    add_extraction(render_app);
    add_rendering(render_app);
    true
}

fn add_render_resources(render_app: &mut SubApp) {
    render_app
        .init_resource::<Mirrors>()
        .init_resource::<RefusedMeshes>()
        .init_resource::<CutOutCasters>()
        .init_resource::<Surfaces>()
        .init_resource::<Deferral>()
        .init_resource::<ForwardShaders>()
        .init_resource::<ForwardViews>()
        .add_render_command::<Opaque3d, DrawShadowed>()
        .add_render_command::<AlphaMask3d, DrawShadowed>()
        .init_resource::<DeferredViews>()
        .init_resource::<LightlessTechniques>();
}

/// Adds the systems that copy the game to the mirrors.
fn add_extraction(render_app: &mut SubApp) {
    render_app
        .configure_sets(
            ExtractSchedule,
            (AntumbraExtractSystems::Collect, AntumbraExtractSystems::Sync).chain(),
        )
        .add_systems(
            RenderStartup,
            (init_pipelines.after(MeshPipelineSystems), forget_mirrors),
        )
        .add_systems(
            ExtractSchedule,
            (
                publish_reports.before(AntumbraExtractSystems::Collect),
                (collect_reloaded, extend_shaders)
                    .chain()
                    .before(AntumbraExtractSystems::Collect),
                (
                    sync_cameras,
                    collect_surfaces,
                    (collect_methods, tell_of_forward).chain(),
                )
                    .in_set(AntumbraExtractSystems::Collect),
                (
                    (
                        sync_setting::<LightClearance>,
                        sync_setting::<OcclusionSettings>,
                        sync_setting::<MapSettings>,
                        sync_setting::<IntervalFolder>,
                    ),
                    sync_transforms,
                    sync_levels,
                    sync_objects,
                    sync_cells,
                    sync_lights,
                    sync_texture_memory,
                    end_sync,
                )
                    .chain()
                    .in_set(AntumbraExtractSystems::Sync),
            ),
        );
}

/// Adds the systems that queue the meshes of marked cameras, and draw their lights.
fn add_rendering(render_app: &mut SubApp) {
    render_app
        .add_systems(
            Render,
            (
                collect_deferred_views.in_set(RenderSystems::PrepareAssets),
                queue_deferred
                    .in_set(RenderSystems::QueueMeshes)
                    .after(queue_material_meshes)
                    .after(queue_prepass_material_meshes),
            ),
        )
        .add_systems(
            Render,
            separate_prepass_textures
                .in_set(RenderSystems::PrepareResources)
                .after(prepare_prepass_textures),
        )
        .add_systems(
            Render,
            prepare_views
                .run_if(resource_exists::<DeferredLightingLayout>) // a game may lack it
                .in_set(RenderSystems::PrepareResources)
                .in_set(AntumbraRenderSystems::Prepare)
                .before(prepare_deferred_lighting_pipelines),
        )
        .add_systems(
            Core3d,
            light_view
                .in_set(Core3dSystems::MainPass)
                .in_set(AntumbraRenderSystems::Light)
                .after(deferred_lighting)
                .before(screen_space_reflections)
                .before(main_opaque_pass_3d),
        );
}

/// The folder of the game's assets, which the maps of lights are relative to. A folder that the game has set is kept.
fn asset_folder(app: &App) -> IntervalFolder {
    if let Some(folder) = app.world().get_resource::<IntervalFolder>() {
        return folder.clone();
    }
    let plugins = app.get_added_plugins::<AssetPlugin>();
    let folder = plugins.first().map(|plugin| plugin.file_path.clone());
    #[cfg(not(any(target_arch = "wasm32", target_os = "android")))]
    let base = bevy::asset::io::file::FileAssetReader::get_base_path();
    #[cfg(any(target_arch = "wasm32", target_os = "android"))]
    let base = std::path::PathBuf::new();
    IntervalFolder(base.join(folder.unwrap_or_default()))
}

/// Removes all mirrors, because what they hold on the GPU is lost with the device.
///
/// Runs in `RenderStartup`.
fn forget_mirrors(mut mirrors: ResMut<Mirrors>, mut forward: ResMut<ForwardViews>) {
    mirrors.clear();
    forward.clear();
}
