//! Finds objects whose inside the camera may see.

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;

use crate::geometry::Aabb;
use crate::scene::changes::{Exchanges, NewAppearances};
use crate::scene::{SceneMaterials, SceneMesh};
use crate::sets::index::objects::resize;
use crate::sets::{Objects, Touch, View};

/// Objects, by dense index, that may have a visible point inside their bounds: the near rectangle touches the
/// bounds, or the object is not fully opaque, or it is not drawn at all. Written by [`collect_seen_into`].
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct SeenInto(pub FixedBitSet);

/// Properties of objects that depend only on materials. Written by [`collect_seen_into`].
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct SeeThrough {
    /// Objects that are not opaque on every surface or are not drawn, by dense index.
    pub objects: FixedBitSet,
    /// Objects whose every surface is drawn from both sides, regardless of
    /// [`FaceCulling`](crate::scene::FaceCulling), by dense index.
    pub two_sided: FixedBitSet,
    generation: Option<(u64, u64)>,
}

/// Collects [`SeeThrough`] and [`SeenInto`].
///
/// Set: `CollectSets`, after the objects and the view. Cost: all clusters, and the objects whose mesh or material was
/// exchanged, or all if one came or went; nothing in a frame at rest.
pub fn collect_seen_into(
    mut seen_into: ResMut<SeenInto>,
    mut see_through: ResMut<SeeThrough>,
    objects: Res<Objects>,
    view: Res<View>,
    appearance: Query<(&SceneMesh, &SceneMaterials)>,
    mut appearances: NewAppearances,
    mut last_view: Local<Option<u64>>,
) {
    let generation = Some((objects.layout_generation, objects.flags_generation));
    let exchanges = appearances.take();
    let rebuilt = see_through.generation != generation || exchanges == Exchanges::Unknown;
    let unchanged = !rebuilt && exchanges.is_none();
    if unchanged && last_view.replace(view.generation) == Some(view.generation) && objects.moved.is_clear() {
        return; // no input changed
    }
    *last_view = Some(view.generation);
    let see_through = &mut *see_through;
    if rebuilt {
        see_through.generation = generation;
        resize(&mut see_through.objects, objects.len());
        resize(&mut see_through.two_sided, objects.len());
    }
    let look = |object: usize| {
        let (opaque, two_sided) =
            appearance
                .get(objects.entities[object])
                .map_or((false, false), |(mesh, materials)| {
                    let two_sided = materials.0.iter().all(|material| material.double_sided);
                    (materials.are_opaque(&mesh.0), two_sided)
                });
        see_through.objects.set(object, !opaque);
        see_through.two_sided.set(object, two_sided);
    };
    if let (Exchanges::Of(entities), false) = (exchanges, rebuilt) {
        let known = entities.iter().filter_map(|&entity| objects.index_of(entity));
        known.for_each(look);
    } else {
        (0..objects.len()).for_each(look);
    }
    seen_into.0.clone_from(&see_through.objects);
    let Some(view) = &view.data else {
        return;
    };
    // The box is padded like those of objects, so that the rounding of its corners loses nothing.
    let near = Aabb::from_points(view.near_corners.map(|corner| corner.as_vec3())).padded();
    let words = seen_into.0.as_mut_slice();
    objects.clusters.find(
        None,
        |boxes, word, candidates| Touch {
            touching: boxes.touching_box(word, candidates, &near),
            inside: 0,
        },
        |found| {
            let present = objects.present.as_slice()[found.word];
            words[found.word] |= objects.boxes.touching_box(found.word, present, &near);
        },
    );
}
