//! Warnings about cameras that cannot show the shadows of this crate. Each is logged once.

use bevy::camera::{Camera, Camera3d, Hdr};
use bevy::ecs::archetype::Archetypes;
use bevy::ecs::component::Components;
use bevy::ecs::prelude::*;
use bevy::ecs::system::SystemParam;
use bevy::light::{DirectionalLight, PointLight, RectLight, SpotLight};
use bevy::render::occlusion_culling::OcclusionCulling;

use super::camera::{AntumbraCamera, named};
use super::techniques::TechniqueComponents;

/// Marks a camera whose fault has been logged. It is removed when the fault is mended.
#[derive(Component)]
pub(super) struct Warned;

/// Marks a camera whose missing [`AntumbraCamera`] has been logged.
#[derive(Component)]
pub(super) struct ToldUnmarked;

/// Access to the game's archetypes, which show whether the game has a managed light.
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

/// Warns once about a marked camera that cannot show shadows correctly: it has no `Hdr`, has `OcclusionCulling`, or inverts
/// culling. Without `Hdr`, Bevy alone lights the camera's view until this is mended.
pub(super) fn warn_of_marked(
    mut commands: Commands,
    cameras: Query<
        (
            Entity,
            Option<&Name>,
            &Camera,
            Has<Hdr>,
            Has<OcclusionCulling>,
            Has<Warned>,
        ),
        With<AntumbraCamera>,
    >,
) {
    for (camera, name, settings, hdr, occlusion, warned) in &cameras {
        let wrong = if !hdr {
            Some("it has no `Hdr`: lights cannot be added to a picture that is tonemapped already")
        } else if occlusion {
            Some("Bevy's `OcclusionCulling` does not go with `DeferredPrepass`: objects may be missing")
        } else if settings.invert_culling {
            Some(
                "Bevy's prepasses ignore `Camera::invert_culling`: faces may be missing. Mirror the picture that it draws instead",
            )
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

/// Warns once about each active camera without the marker that it shows no shadows of managed lights.
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

/// Warns once about a marked camera in an app that has no renderer.
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
