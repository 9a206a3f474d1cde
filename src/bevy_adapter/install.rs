//! Registration: what [`AntumbraPlugin`](crate::plugin::AntumbraPlugin) does in an app of Bevy's.

use bevy::app::{App, Last, PostUpdate};
use bevy::asset::{AssetEventSystems, Assets};
use bevy::core_pipeline::core_3d::main_opaque_pass_3d;
use bevy::core_pipeline::schedule::{Core3d, Core3dSystems};
use bevy::ecs::prelude::*;
use bevy::pbr::deferred::{deferred_lighting, prepare_deferred_lighting_pipelines};
use bevy::pbr::{DefaultOpaqueRendererMethod, MeshPipelineSystems, screen_space_reflections};
use bevy::render::{ExtractSchedule, Render, RenderApp, RenderStartup, RenderSystems};
use bevy::shader::Shader;

use super::camera::{AntumbraCamera, check_cameras, defer_other_cameras, warn_without_renderer};
use super::mesh_library::{MeshLibrary, collect_meshes};
use super::mirror::Mirrors;
use super::pass::light_view;
use super::pipelines::{AntumbraShaders, init_pipelines};
use super::prepare::prepare_views;
use super::refused::RefusedMeshes;
use super::report::{LightlessTechniques, publish_reports};
use super::settings::AntumbraSettings;
use super::surfaces::{Surfaces, collect_surfaces};
use super::sync::{end_sync, sync_cameras, sync_transforms};
use super::sync_lights::sync_lights;
use super::sync_objects::sync_objects;
use super::systems::{AntumbraExtractSystems, AntumbraMainSystems, AntumbraRenderSystems};
use super::techniques::{AddShadowTechnique, Techniques, TouchedLights};
use crate::reports::Reports;
use crate::scene::LightSelection;
use crate::techniques::{OmniMap, PenumbraWedge, ShadowMap, StencilVolume};

/// Installs the adapter if the app has Bevy's renderer; `false` if it does not.
pub fn install(app: &mut App) -> bool {
    app.register_type::<AntumbraCamera>()
        .register_type::<StencilVolume>()
        .register_type::<PenumbraWedge>()
        .register_type::<ShadowMap>()
        .register_type::<OmniMap>()
        .register_type::<LightSelection>();
    if app.get_sub_app(RenderApp).is_none() {
        app.add_systems(Last, warn_without_renderer); // where nothing of the core runs
        return false;
    }
    app.insert_resource(DefaultOpaqueRendererMethod::deferred())
        .init_resource::<AntumbraSettings>()
        .init_resource::<MeshLibrary>()
        .init_resource::<Reports>()
        .add_systems(
            PostUpdate,
            (check_cameras, defer_other_cameras).in_set(AntumbraMainSystems::CheckCameras),
        )
        .add_systems(
            PostUpdate,
            collect_meshes
                .in_set(AntumbraMainSystems::CollectMeshes)
                .after(AssetEventSystems),
        );
    app.add_shadow_technique::<StencilVolume>(|_, _| ())
        .add_shadow_technique::<PenumbraWedge>(|_, _| ())
        .add_shadow_technique::<ShadowMap>(|_, _| ())
        .add_shadow_technique::<OmniMap>(|_, _| ());
    let shaders = AntumbraShaders::add(&mut app.world_mut().resource_mut::<Assets<Shader>>());
    let render_app = app.sub_app_mut(RenderApp);
    render_app
        .insert_resource(shaders)
        .init_resource::<Mirrors>()
        .init_resource::<RefusedMeshes>()
        .init_resource::<Surfaces>()
        .init_resource::<Techniques>()
        .init_resource::<TouchedLights>()
        .init_resource::<LightlessTechniques>()
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
                (sync_cameras, collect_surfaces).in_set(AntumbraExtractSystems::Collect),
                (sync_transforms, sync_objects, sync_lights, end_sync)
                    .chain()
                    .in_set(AntumbraExtractSystems::Sync),
            ),
        )
        .add_systems(
            Render,
            prepare_views
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
    true
}

/// What they hold on the GPU went with the device. `RenderStartup`.
fn forget_mirrors(mut mirrors: ResMut<Mirrors>) {
    mirrors.clear();
}
