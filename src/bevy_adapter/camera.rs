//! The camera that shows our shadows: what its marker brings, keeps and takes back.

use bevy::camera::{Camera3d, Hdr};
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass};
use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::prelude::*;
use bevy::ecs::reflect::ReflectComponent;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::ReflectDefault;
use bevy::reflect::Reflect;
use bevy::render::view::Msaa;

/// Shows the shadows of managed lights: put it beside `Camera3d`, at any time, and take it away at any time.
///
/// A camera without it is Bevy's alone: its materials are forward or deferred as Bevy has them, and its MSAA stays.
///
/// The marker brings what shadows are computed from: [`Hdr`], [`DepthPrepass`] and [`DeferredPrepass`], those that the
/// camera does not have. It switches [`Msaa`] off, because deferred shading has one sample a pixel, and logs that once;
/// spawn the camera with `Msaa::Off` to agree in advance. Antialias with TAA, FXAA or SMAA instead. While the marker is
/// there, a prepass that is taken away is put back. When the marker is removed, the camera loses what the marker brought
/// and has its MSAA again.
///
/// Opaque and alpha-masked meshes of materials whose `opaque_render_method` is `Auto` are drawn deferred for this camera
/// and stay as they are for others. A material that has no deferred shader stays forward, keeps its look, and is named in
/// the log.
///
/// Each such camera keeps a copy of the shadow scene of its own (bounds, silhouettes, buffers), so that its costs in
/// time and memory count once for each camera. Meshes in main memory and their edges are shared.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
#[component(on_add = on_marked, on_remove = on_unmarked)]
#[require(Camera3d)]
pub struct AntumbraCamera;

/// What the marker brought to a camera and takes back when it goes.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(super) struct Brought {
    hdr: bool,
    depth_prepass: bool,
    deferred_prepass: bool,
    /// The MSAA that was switched off.
    msaa: Option<Msaa>,
}

/// What was said about a camera. It stays when the marker goes: everything is said once.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(super) struct Told {
    msaa: bool,
    prepass: bool,
}

fn on_marked(mut world: DeferredWorld, context: HookContext) {
    let mut commands = world.commands();
    commands
        .entity(context.entity)
        .queue_silenced(|camera: EntityWorldMut| bring(camera));
}

fn on_unmarked(mut world: DeferredWorld, context: HookContext) {
    let mut commands = world.commands();
    commands
        .entity(context.entity)
        .queue_silenced(|camera: EntityWorldMut| take_back(camera));
}

fn bring(mut camera: EntityWorldMut) {
    if !camera.contains::<AntumbraCamera>() {
        return; // it was taken away in the same breath
    }
    // A clone of a marked camera has what its original was brought.
    let mut brought = camera.get::<Brought>().copied().unwrap_or_default();
    let mut told = camera.get::<Told>().copied().unwrap_or_default();
    brought.hdr |= !camera.contains::<Hdr>();
    brought.depth_prepass |= !camera.contains::<DepthPrepass>();
    brought.deferred_prepass |= !camera.contains::<DeferredPrepass>();
    if let Some(msaa) = camera.get::<Msaa>().copied() {
        let named = named(camera.id(), camera.get());
        switch_off(msaa, &mut brought, &mut told, &named);
    }
    camera.insert((Msaa::Off, brought, told));
    camera.insert_if_new((Hdr, DepthPrepass, DeferredPrepass));
}

fn take_back(mut camera: EntityWorldMut) {
    if camera.contains::<AntumbraCamera>() {
        return; // it came back in the same breath
    }
    let Some(brought) = camera.take::<Brought>() else {
        return;
    };
    if brought.hdr {
        camera.remove::<Hdr>();
    }
    if brought.depth_prepass {
        camera.remove::<DepthPrepass>();
    }
    if brought.deferred_prepass {
        camera.remove::<DeferredPrepass>();
    }
    if let Some(msaa) = brought.msaa {
        camera.insert(msaa);
    }
}

/// Remembers the MSAA of a camera for the time after the marker, and says once that it is off.
fn switch_off(msaa: Msaa, brought: &mut Brought, told: &mut Told, named: &str) {
    if msaa == Msaa::Off {
        return;
    }
    brought.msaa = Some(msaa);
    if !std::mem::replace(&mut told.msaa, true) {
        let samples = msaa.samples();
        tracing::warn!(
            "AntumbraCamera switched {samples}x MSAA off on camera {named}: deferred shading has one sample a pixel; \
             antialias with TAA, FXAA or SMAA, and spawn the camera with `Msaa::Off` to silence this"
        );
    }
}

/// Switches MSAA off that a game set on a marked camera. `PostUpdate`, before Bevy looks at it, and again in `Last`, for
/// what was set in between.
pub(super) fn keep_msaa_off(
    mut cameras: Query<
        (Entity, Option<&Name>, &mut Msaa, &mut Brought, &mut Told),
        (With<AntumbraCamera>, Changed<Msaa>),
    >,
) {
    for (camera, name, mut msaa, mut brought, mut told) in &mut cameras {
        if *msaa != Msaa::Off {
            switch_off(*msaa, &mut brought, &mut told, &named(camera, name));
            *msaa = Msaa::Off;
        }
    }
}

/// Puts a prepass back that was taken from a marked camera, before a frame is drawn without it: Bevy would panic in its
/// prepass for deferred materials. An observer.
pub(super) fn put_back<P: Component + Default>(
    removed: On<Remove, P>,
    mut commands: Commands,
    marked: Query<(), With<AntumbraCamera>>,
) {
    if !marked.contains(removed.entity) {
        return;
    }
    commands
        .entity(removed.entity)
        .queue_silenced(|mut camera: EntityWorldMut| {
            if !camera.contains::<AntumbraCamera>() || camera.contains::<P>() {
                return; // the marker went in the same breath, or the prepass came back
            }
            camera.insert(P::default());
            let named = named(camera.id(), camera.get());
            let Some(mut told) = camera.get_mut::<Told>() else {
                return;
            };
            if !std::mem::replace(&mut told.prepass, true) {
                tracing::warn!(
                    "camera {named} keeps its `DepthPrepass` and `DeferredPrepass` while it has `AntumbraCamera`: \
                     shadows are computed from them; remove `AntumbraCamera` first"
                );
            }
        });
}

/// An entity as a log names it.
pub(super) fn named(entity: Entity, name: Option<&Name>) -> String {
    match name {
        Some(name) => format!("`{name}` ({entity})"),
        None => entity.to_string(),
    }
}
