//! Objects and markers that come and go, counted where it happens.

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

/// How often a component that makes an entity a member of a set was added to or removed from any entity:
/// [`WorldBounds`](super::WorldBounds), [`ShadowCaster`](super::ShadowCaster),
/// [`ShadowReceiver`](super::ShadowReceiver), [`SceneMaterials`](super::SceneMaterials),
/// [`SelectionLayers`](super::SelectionLayers). Written by their hooks, so that nobody has to look for them each frame.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ObjectChurn(pub u64);

/// The hook of those components.
pub(super) fn count_churn(mut world: DeferredWorld, _: HookContext) {
    if let Some(mut churn) = world.get_resource_mut::<ObjectChurn>() {
        churn.0 += 1;
    }
}
