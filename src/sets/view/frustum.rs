//! Set F: objects whose bounds touch the view frustum.

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;

use super::frame_view::View;
use crate::sets::index::objects::{Objects, resize};
use crate::sets::work::SetWork;

/// The set F: objects whose bounds touch the view frustum. Written by [`collect_frustum_set`].
#[derive(Resource, Clone, Debug, Default)]
pub struct FrustumSet {
    /// Objects whose bounds touch the frustum, occluded or not.
    pub set: FixedBitSet,
    /// Increases when the whole set was recomputed, as opposed to only the objects that moved.
    pub generation: u64,
    seen: (u64, u64),
}

/// Tests bounds against the frustum: all bounds if the view or the layout changed, otherwise those in words
/// in which something moved.
///
/// Set: `CollectSets`, after `collect_objects` and `collect_view`. Conservative: it may keep an object whose
/// box passes outside an edge of the frustum, but never drops one that is inside. Cost: all clusters, and the
/// objects of those clusters that the frustum's planes cut.
pub fn collect_frustum_set(
    mut frustum_set: ResMut<FrustumSet>,
    mut work: ResMut<SetWork>,
    objects: Res<Objects>,
    view: Res<View>,
) {
    let now = (objects.layout_generation, view.generation);
    let everything = frustum_set.seen != now;
    if !everything && !objects.any_moved() {
        return;
    }
    let frustum_set = &mut *frustum_set;
    if everything {
        resize(&mut frustum_set.set, objects.len());
        frustum_set.generation += 1;
        frustum_set.seen = now;
    }
    let Some(view) = &view.data else {
        return;
    };
    let words = frustum_set.set.as_mut_slice();
    let present = objects.present.as_slice();
    let among = (!everything).then_some(&objects.moved_words);
    if let Some(moved) = among {
        moved.ones().for_each(|word| words[word] = 0);
    }
    let planes = &view.frustum.planes;
    objects.clusters.find(
        among,
        |boxes, word, candidates| boxes.clusters_touching_planes(word, candidates, planes),
        |found| {
            work.frustum_words += 1;
            words[found.word] = if found.inside {
                present[found.word]
            } else {
                objects
                    .boxes
                    .touching_planes(found.word, present[found.word], planes)
            };
        },
    );
}
