//! Marks the submeshes that cast nothing although other submeshes of their object cast.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;

use super::inverted_hulls::InvertedHulls;
use super::invisible::InvisibleObjects;
use crate::scene::{LeftOutSubmeshes, ObjectChurn, Submeshes};

/// Brings [`LeftOutSubmeshes`] up to date.
///
/// Set: `CollectSets`, after both lists and before the objects. Cost: a comparison of the lists, which name only objects that
/// have such a submesh. The components are written only where they change.
pub fn leave_out_submeshes(
    mut commands: Commands,
    mut known: Local<Vec<(Entity, Submeshes)>>,
    mut churn: ResMut<ObjectChurn>,
    invisible: Res<InvisibleObjects>,
    hulls: Res<InvertedHulls>,
    mut marked: Query<(Entity, &mut LeftOutSubmeshes)>,
) {
    let parts = || invisible.parts().iter().chain(hulls.parts());
    if parts().eq(known.iter()) {
        return;
    }
    known.clear();
    known.extend(parts().cloned());
    let mut wanted: BTreeMap<Entity, Submeshes> = BTreeMap::new();
    for (entity, submeshes) in parts() {
        let wanted = wanted.entry(*entity).or_default();
        wanted.extend_from_slice(submeshes);
        wanted.sort_unstable();
        wanted.dedup();
    }
    for (entity, mut marked) in &mut marked {
        let submeshes = wanted.remove(&entity).unwrap_or_default();
        marked.set_if_neq(LeftOutSubmeshes(submeshes));
    }
    for (entity, submeshes) in wanted {
        commands.entity(entity).try_insert(LeftOutSubmeshes(submeshes));
    }
    churn.0 += 1; // the objects and their occluders are collected anew
}
