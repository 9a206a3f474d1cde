//! From the game's world to the mirrors: cameras, places, and what is gone. Objects and lights have files of their own.

use bevy::camera::visibility::RenderLayers;
use bevy::ecs::prelude::*;
use bevy::render::Extract;
use bevy::transform::components::GlobalTransform;

use super::camera::AntumbraCamera;
use super::mirror::{Mirror, Mirrors};
use crate::techniques::Techniques;

/// Gives every marked camera a mirror, and takes those of others away. A camera that sees other layers than before gets
/// a new one.
///
/// `ExtractSchedule`, [`Collect`](super::AntumbraExtractSystems::Collect).
pub(super) fn sync_cameras(
    mut mirrors: ResMut<Mirrors>,
    techniques: Res<Techniques>,
    cameras: Extract<Query<(Entity, Option<&RenderLayers>), With<AntumbraCamera>>>,
) {
    mirrors.retain(|camera| cameras.contains(camera));
    for (camera, layers) in &cameras {
        let layers = layers.unwrap_or_default();
        match mirrors.get_mut(camera) {
            Some(mirror) if mirror.layers == *layers => {}
            Some(mirror) => {
                let view = std::mem::take(&mut mirror.view);
                *mirror = Mirror::new(layers.clone(), &techniques);
                mirror.view = view;
            }
            None => mirrors.insert(camera, Mirror::new(layers.clone(), &techniques)),
        }
    }
}

/// Moves what moved: objects, joints and lights alike. In a steady frame it only reads change ticks.
///
/// `ExtractSchedule`, [`Sync`](super::AntumbraExtractSystems::Sync), first. What appears in this frame takes its place
/// when it is made.
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

/// Everything has been taken over.
///
/// `ExtractSchedule`, [`Sync`](super::AntumbraExtractSystems::Sync), last.
pub(super) fn end_sync(mut mirrors: ResMut<Mirrors>) {
    for mirror in mirrors.iter_mut() {
        mirror.fresh = false;
    }
}
