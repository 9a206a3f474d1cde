//! The camera that shows our shadows, and what it must be.

use bevy::camera::{Camera3d, Hdr};
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass};
use bevy::ecs::prelude::*;
use bevy::ecs::reflect::ReflectComponent;
use bevy::prelude::ReflectDefault;
use bevy::reflect::Reflect;
use bevy::render::occlusion_culling::OcclusionCulling;
use bevy::render::view::Msaa;

use super::settings::AntumbraSettings;

/// Shows the shadows of managed lights: put it beside `Camera3d`.
///
/// A camera without it is Bevy's alone. It needs what it requires: deferred shading with a depth prepass, into an HDR
/// texture of one sample. Antialias with TAA, FXAA or SMAA.
///
/// Each such camera keeps a copy of the shadow scene of its own (bounds, silhouettes, buffers), so that its costs in
/// time and memory count once for each camera. Meshes in main memory and their edges are shared.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
#[require(Camera3d, Hdr, DepthPrepass, DeferredPrepass, Msaa::Off)]
pub struct AntumbraCamera;

/// What a camera must be.
type CameraItem<'a> = (
    Entity,
    Has<Hdr>,
    Has<DepthPrepass>,
    Has<DeferredPrepass>,
    Has<OcclusionCulling>,
);

/// A camera's warning has been given. Goes when the camera is right again.
#[derive(Component)]
pub struct Warned;

/// Warns once of a camera that cannot show our shadows: until it is changed, its lights are Bevy's. (Of MSAA, which deferred
/// shading has not, Bevy itself warns, and turns it off.)
pub(super) fn check_cameras(
    mut commands: Commands,
    cameras: Query<(CameraItem<'static>, Has<Warned>), With<AntumbraCamera>>,
) {
    for ((camera, hdr, depth, deferred, occlusion), warned) in &cameras {
        let mut wrong: Option<&str> = None;
        if !hdr {
            wrong = Some("it has no `Hdr`: lights cannot be added to a picture that is tonemapped already");
        } else if !depth || !deferred {
            wrong = Some("it lacks `DepthPrepass` or `DeferredPrepass`, which shadows are computed from");
        } else if occlusion {
            wrong =
                Some("Bevy's `OcclusionCulling` does not go with `DeferredPrepass`: objects may be missing");
        }
        match wrong {
            Some(wrong) if !warned => {
                tracing::warn!("AntumbraCamera {camera}: {wrong}");
                commands.entity(camera).insert(Warned);
            }
            None if warned => {
                commands.entity(camera).remove::<Warned>();
            }
            _ => {}
        }
    }
}

/// Gives 3D cameras without the marker the prepass that deferred materials are seen by
/// ([`AntumbraSettings::defer_other_cameras`]).
pub(super) fn defer_other_cameras(
    mut commands: Commands,
    settings: Res<AntumbraSettings>,
    cameras: Query<Entity, (Added<Camera3d>, Without<AntumbraCamera>, Without<DeferredPrepass>)>,
) {
    for camera in cameras.iter().filter(|_| settings.defer_other_cameras) {
        commands.entity(camera).insert((DepthPrepass, DeferredPrepass));
    }
}

/// Warns once of a marked camera in an app that has no renderer.
pub(super) fn warn_without_renderer(cameras: Query<Entity, Added<AntumbraCamera>>, mut warned: Local<bool>) {
    if let Some(camera) = cameras.iter().next().filter(|_| !*warned) {
        *warned = true;
        tracing::warn!(
            "AntumbraCamera {camera}: there is no renderer to show shadows; add AntumbraPlugin after DefaultPlugins"
        );
    }
}
