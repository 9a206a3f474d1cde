//! Set V: objects of F that the camera may see.

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;

use super::frustum::FrustumSet;
use super::objects::Objects;

/// Set V. Written by [`collect_visible_set`].
#[derive(Resource, Clone, Debug, Default)]
pub struct VisibleSet {
    /// Objects of F that are not occluded from the camera.
    pub set: FixedBitSet,
    /// Increases when objects may have entered or left the set other than by having moved themselves.
    pub generation: u64,
    seen: u64,
}

/// V = F: there is no occlusion from the camera yet, and this step is where it takes objects out.
///
/// Set: `CollectSets`, after `collect_frustum_set`.
pub fn collect_visible_set(
    mut visible: ResMut<VisibleSet>,
    frustum_set: Res<FrustumSet>,
    objects: Res<Objects>,
) {
    let anew = visible.seen != frustum_set.generation;
    if anew {
        visible.seen = frustum_set.generation;
        visible.generation += 1;
        if visible.set.len() != frustum_set.set.len() {
            visible.set = FixedBitSet::with_capacity(frustum_set.set.len());
        }
    }
    if anew || !objects.moved.is_clear() {
        visible
            .set
            .as_mut_slice()
            .copy_from_slice(frustum_set.set.as_slice());
    }
}
