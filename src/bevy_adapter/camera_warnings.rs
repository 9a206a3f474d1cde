//! Warnings of cameras that show no shadows of ours, each given once.

use bevy::camera::{Camera, Camera3d, Hdr};
use bevy::ecs::archetype::Archetypes;
use bevy::ecs::component::Components;
use bevy::ecs::prelude::*;
use bevy::ecs::system::SystemParam;
use bevy::light::{DirectionalLight, PointLight, RectLight, SpotLight};
use bevy::render::occlusion_culling::OcclusionCulling;

use super::camera::{AntumbraCamera, named};
use super::techniques::TechniqueComponents;

/// A camera's warning has been given. Goes when the camera is right again.
#[derive(Component)]
pub(super) struct Warned;

/// It has been said that the camera is not marked.
#[derive(Component)]
pub(super) struct ToldUnmarked;

/// Whether the game has a managed light.
#[derive(SystemParam)]
pub(super) struct ManagedLights<'w> {
    techniques: Res<'w, TechniqueComponents>,
    archetypes: &'w Archetypes,
    components: &'w Components,
}

impl ManagedLights<'_> {
    fn exist(&self) -> bool {
        let lights = [
            self.components.component_id::<PointLight>(),
            self.components.component_id::<SpotLight>(),
            self.components.component_id::<DirectionalLight>(),
            self.components.component_id::<RectLight>(),
        ];
        self.archetypes.iter().any(|archetype| {
            !archetype.is_empty()
                && self.techniques.0.iter().any(|&id| archetype.contains(id))
                && lights.iter().flatten().any(|&id| archetype.contains(id))
        })
    }
}

/// Warns once of a marked camera that cannot show our shadows: until it is changed, its lights are Bevy's.
pub(super) fn warn_of_marked(
    mut commands: Commands,
    cameras: Query<
        (
            Entity,
            Option<&Name>,
            Has<Hdr>,
            Has<OcclusionCulling>,
            Has<Warned>,
        ),
        With<AntumbraCamera>,
    >,
) {
    for (camera, name, hdr, occlusion, warned) in &cameras {
        let wrong = if !hdr {
            Some("it has no `Hdr`: lights cannot be added to a picture that is tonemapped already")
        } else if occlusion {
            Some("Bevy's `OcclusionCulling` does not go with `DeferredPrepass`: objects may be missing")
        } else {
            None
        };
        match wrong {
            Some(wrong) if !warned => {
                tracing::warn!("AntumbraCamera {}: {wrong}", named(camera, name));
                commands.entity(camera).try_insert(Warned);
            }
            None if warned => {
                commands.entity(camera).try_remove::<Warned>();
            }
            _ => {}
        }
    }
}

/// Says once of each camera without the marker that managed lights throw no shadows for it.
pub(super) fn warn_of_unmarked(
    mut commands: Commands,
    cameras: Query<
        (Entity, Option<&Name>, &Camera),
        (With<Camera3d>, Without<AntumbraCamera>, Without<ToldUnmarked>),
    >,
    managed: ManagedLights,
) {
    if cameras.is_empty() || !managed.exist() {
        return;
    }
    for (camera, name, _) in cameras.iter().filter(|(_, _, camera)| camera.is_active) {
        tracing::warn!(
            "camera {} shows no shadows of the lights that have a shadow technique: insert `AntumbraCamera` beside its \
             `Camera3d`",
            named(camera, name)
        );
        commands.entity(camera).try_insert(ToldUnmarked);
    }
}

/// Warns once of a marked camera in an app that has no renderer.
pub(super) fn warn_without_renderer(
    cameras: Query<(Entity, Option<&Name>), Added<AntumbraCamera>>,
    mut warned: Local<bool>,
) {
    if let Some((camera, name)) = cameras.iter().next().filter(|_| !*warned) {
        *warned = true;
        tracing::warn!(
            "AntumbraCamera {}: there is no renderer to show shadows; add `DefaultPlugins`, or `RenderPlugin`, \
             `CorePipelinePlugin` and `PbrPlugin`",
            named(camera, name)
        );
    }
}
