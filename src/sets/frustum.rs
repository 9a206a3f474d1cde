//! Set F: objects whose bounds touch the view frustum.

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;

use super::boxes::WORD;
use super::objects::{Objects, resize};
use super::view::View;
use super::work::SetWork;

/// Set F. Written by [`collect_frustum_set`].
#[derive(Resource, Clone, Debug, Default)]
pub struct FrustumSet {
    /// Objects whose bounds touch the frustum, occluded or not.
    pub set: FixedBitSet,
    /// Increases when the set was computed anew, not only where objects moved.
    pub generation: u64,
    seen: (u64, u64),
}

/// Bits of a word that are objects at all.
pub(super) fn present_word(objects: &Objects, word: usize) -> usize {
    objects.present.as_slice()[word]
}

/// Tests bounds against the frustum: all if the view or the layout changed, else words in which something moved.
///
/// Set: `CollectSets`, after `collect_objects` and `collect_view`. Conservative: it may keep an object whose box passes
/// outside an edge of the frustum, it never drops one that is inside.
pub fn collect_frustum_set(
    mut frustum_set: ResMut<FrustumSet>,
    mut work: ResMut<SetWork>,
    objects: Res<Objects>,
    view: Res<View>,
) {
    let now = (objects.layout_generation, view.generation);
    let everything = frustum_set.seen != now;
    if !everything && objects.moved.is_clear() {
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
    let planes = &view.frustum.planes;
    let words = frustum_set.set.as_mut_slice();
    let mut test = |word: usize| {
        work.frustum_words += 1;
        words[word] = objects
            .boxes
            .touching_planes(word, present_word(&objects, word), planes);
    };
    if everything {
        (0..objects.len().div_ceil(WORD)).for_each(&mut test);
    } else {
        objects.moved_words().for_each(|(word, _)| test(word));
    }
}
