//! The marker of cameras that show the shadows of this crate, and the components that the marker adds and
//! removes.

use bevy::camera::{Camera3d, Hdr};
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass};
use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::prelude::*;
use bevy::ecs::reflect::ReflectComponent;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::ReflectDefault;
use bevy::reflect::Reflect;
use bevy::render::view::Msaa;

/// Marks a camera that shows the shadows of managed lights. Insert it beside `Camera3d` at any time, and
/// remove it at any time.
///
/// A camera without the marker is rendered by Bevy alone: its materials are forward or deferred as Bevy has
/// them, and its MSAA stays.
///
/// The marker adds the components that shadows need, if the camera lacks them: [`Hdr`], [`DepthPrepass`] and
/// [`DeferredPrepass`]. While the marker is there, a prepass that is removed is inserted again. The marker
/// also sets [`Msaa`] to off, because deferred shading has one sample a pixel, and logs a warning once. Spawn
/// the camera with `Msaa::Off` to avoid the warning, and antialias with TAA, FXAA or SMAA instead. When the
/// marker is removed, the components that it added are removed too, and the camera gets its MSAA back.
///
/// Opaque and alpha-masked meshes of materials whose `opaque_render_method` is `Auto` are drawn deferred for
/// this camera. For other cameras they are drawn as before. A material without a deferred shader stays
/// forward and keeps its look; what keeps it from showing shadows is named in the log.
///
/// Each marked camera keeps its own copy of the shadow scene (bounds, silhouettes, buffers), so its cost in
/// time and memory counts once for each camera. Meshes in main memory and their edges are shared.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
#[component(on_add = on_marked, on_remove = on_unmarked)]
#[require(Camera3d)]
pub struct AntumbraCamera;

/// The changes that the marker made to a camera. They are undone when the marker is removed.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(super) struct Brought {
    hdr: bool,
    depth_prepass: bool,
    deferred_prepass: bool,
    /// The MSAA that the camera had before the marker switched it off; `None` if it was off.
    msaa: Option<Msaa>,
}

/// Warnings that were already logged about a camera. The component stays when the marker is removed, so that
/// each warning is logged once.
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
        return; // the marker was removed before this command ran
    }
    // A clone of a marked camera also has a clone of the original's `Brought`.
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
        return; // the marker was inserted again before this command ran
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

/// Records the MSAA that the camera gets back when the marker is removed, and warns once that MSAA is off.
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

/// Switches off the MSAA that a game has set on a marked camera.
///
/// Runs in `PostUpdate`, before Bevy reads the MSAA, and again in `Last`, because systems in between may set
/// it.
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

/// Observes the removal of the prepass `P` from a marked camera, and inserts the prepass again before a frame
/// is drawn. Without it, Bevy's prepass would panic on deferred materials.
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
                return; // the marker is gone too, or the prepass is back already
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

/// Returns the text that names an entity in the log.
pub(super) fn named(entity: Entity, name: Option<&Name>) -> String {
    match name {
        Some(name) => format!("`{name}` ({entity})"),
        None => entity.to_string(),
    }
}
