//! Synchronisation of the mirrors with the game's world: cameras, transforms and removed entities. Objects
//! and lights have files of their own.

use bevy::camera::Camera;
use bevy::camera::visibility::RenderLayers;
use bevy::ecs::prelude::*;
use bevy::render::Extract;
use bevy::transform::components::GlobalTransform;

use super::camera::AntumbraCamera;
use super::mirror::{Mirror, Mirrors};
use super::settings::AntumbraSettings;
use crate::techniques::{Techniques, TextureMemory};

/// Frames without a picture after which a camera's mirror is given up.
const KEPT_FRAMES: u32 = 120;

/// Gives every marked camera a mirror, and removes the mirrors of other cameras. A camera whose layers
/// changed gets a new mirror. A mirror that is not drawn collects the changes of the game, so it is replaced after
/// [`KEPT_FRAMES`] frames, or removed until its camera is active again.
///
/// Runs in `ExtractSchedule`. Set: [`Collect`](super::AntumbraExtractSystems::Collect).
pub(super) fn sync_cameras(
    mut mirrors: ResMut<Mirrors>,
    techniques: Res<Techniques>,
    cameras: Extract<Query<(Entity, Option<&RenderLayers>, &Camera), With<AntumbraCamera>>>,
) {
    for mirror in mirrors.iter_mut() {
        mirror.idle_frames = if mirror.has_run { 0 } else { mirror.idle_frames + 1 };
        mirror.has_run = false;
    }
    mirrors.retain(|camera, mirror| {
        let is_active = |(_, _, camera): (_, _, &Camera)| camera.is_active;
        cameras.get(camera).is_ok_and(is_active)
            || cameras.contains(camera) && mirror.idle_frames < KEPT_FRAMES
    });
    for (camera, layers, settings) in &cameras {
        let layers = layers.unwrap_or_default();
        match mirrors.get_mut(camera) {
            Some(mirror) if mirror.idle_frames >= KEPT_FRAMES => {
                *mirror = Mirror::new(layers.clone(), &techniques);
            }
            Some(mirror) if mirror.layers == *layers => {}
            Some(mirror) => {
                let view = std::mem::take(&mut mirror.view);
                *mirror = Mirror::new(layers.clone(), &techniques);
                mirror.view = view;
            }
            None if !settings.is_active => {}
            None => mirrors.insert(camera, Mirror::new(layers.clone(), &techniques)),
        }
    }
}

/// Copies changed transforms of objects, joints and lights to the mirrors. Despawns the mirrors' entities for
/// game entities that are gone. In a steady frame it only reads change ticks.
///
/// Runs in `ExtractSchedule`. Set: [`Sync`](super::AntumbraExtractSystems::Sync), first. Entities that appear
/// in this frame get their transform when the later systems of the set spawn them.
pub(super) fn sync_transforms(
    mut mirrors: ResMut<Mirrors>,
    moved: Extract<Query<(Entity, &GlobalTransform), Changed<GlobalTransform>>>,
    mut gone: Extract<RemovedComponents<GlobalTransform>>,
    alive: Extract<Query<(), With<GlobalTransform>>>,
    mut ended: Local<Vec<Entity>>,
) {
    ended.clear();
    ended.extend(gone.read().filter(|&entity| !alive.contains(entity)));
    for mirror in mirrors.iter_mut() {
        for &entity in &*ended {
            mirror.despawn(entity);
        }
        for (entity, transform) in &moved {
            mirror.place(entity, transform);
        }
    }
}

/// Copies the limit on the memory of textures to the mirrors.
///
/// Runs in `ExtractSchedule`. Set: [`Sync`](super::AntumbraExtractSystems::Sync).
pub(super) fn sync_texture_memory(
    mut mirrors: ResMut<Mirrors>,
    settings: Extract<Option<Res<AntumbraSettings>>>,
) {
    let Some(settings) = settings.as_ref() else {
        return;
    };
    for mirror in mirrors.iter_mut() {
        mirror.world.resource_mut::<TextureMemory>().limit = settings.texture_memory;
    }
}

/// Marks all mirrors as synchronised.
///
/// Runs in `ExtractSchedule`. Set: [`Sync`](super::AntumbraExtractSystems::Sync), last.
pub(super) fn end_sync(mut mirrors: ResMut<Mirrors>) {
    for mirror in mirrors.iter_mut() {
        mirror.fresh = false;
    }
}
