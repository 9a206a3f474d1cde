//! Counts objects and markers that come and go, at the place where it happens.

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

/// How often a component that makes an entity a member of a set was added to or removed from any entity.
/// These components are [`WorldBounds`](super::WorldBounds), [`ShadowCaster`](super::ShadowCaster),
/// [`ShadowReceiver`](super::ShadowReceiver), [`SceneMaterials`](super::SceneMaterials),
/// [`SelectionLayers`](super::SelectionLayers), and [`PosedMesh`](super::PosedMesh), with which an object has vertices of its own. Their hooks write the count, so that no system has to search
/// for changes each frame. [`find_inverted_hulls`](crate::sets::find_inverted_hulls) and
/// [`leave_out_submeshes`](crate::sets::leave_out_submeshes) count what they leave out or take back.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ObjectChurn(pub u64);

/// The component hook that counts an addition or a removal.
pub(super) fn count_churn(mut world: DeferredWorld, _: HookContext) {
    if let Some(mut churn) = world.get_resource_mut::<ObjectChurn>() {
        churn.0 += 1;
    }
}
