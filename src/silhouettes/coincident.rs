//! Casters that coincide with another one: the same triangles in the same place.

use bevy_ecs::prelude::*;

use super::caster_shape::{CasterShape, CasterShapeItem};
use super::casters::{CasterEdges, mixed};
use crate::sets::Objects;

/// Greatest number of different casters with equal bounds that are compared with each other.
const MOST_ALIKE: usize = 8;

/// Casters that coincide with another one. They cast the same shadow, so those with silhouettes leave them out: soft
/// shadows would count them twice where shadows overlap, and volumes would be drawn twice. Written by
/// `find_coincident_casters`.
#[derive(Resource, Debug, Default)]
pub struct CoincidentCasters {
    /// Caster that is left out, and the caster that stands for it, by dense object index, ascending.
    pairs: Vec<(u32, u32)>,
    /// The flags of [`Objects`] for which the pairs were found.
    flags_generation: Option<u64>,
    /// Casters by a number that is equal where bounds are equal; kept for its allocation.
    order: Vec<(u64, u32)>,
}

impl CoincidentCasters {
    /// Returns the caster that stands for this one, if one does.
    pub fn stands_for(&self, object: usize) -> Option<usize> {
        let at = self
            .pairs
            .binary_search_by_key(&(object as u32), |pair| pair.0)
            .ok()?;
        Some(self.pairs[at].1 as usize)
    }

    /// Returns the number of casters that another one stands for.
    pub fn count(&self) -> usize {
        self.pairs.len()
    }

    fn find(&mut self, objects: &Objects, casters: &Query<CasterShape>) {
        let Self { pairs, order, .. } = self;
        pairs.clear();
        order.clear();
        order.extend(objects.casters.ones().map(|object| {
            let bounds = objects.boxes.get(object);
            let sides = [bounds.min, bounds.max].map(|corner| corner.to_array());
            (
                mixed(sides.into_iter().flatten().map(f32::to_bits)),
                object as u32,
            )
        }));
        order.sort_unstable();
        for alike in order.chunk_by(|a, b| a.0 == b.0).filter(|alike| alike.len() > 1) {
            let first = pairs.len();
            for (at, &(_, object)) in alike.iter().enumerate().skip(1) {
                let left_out = |other: u32| pairs[first..].iter().any(|pair| pair.0 == other);
                let different = alike[..at].iter().map(|&(_, other)| other);
                let mut different = different.filter(|other| !left_out(*other)).take(MOST_ALIKE);
                if let Some(other) = different.find(|&other| coincide(object, other, objects, casters)) {
                    pairs.push((object, other));
                }
            }
        }
        pairs.sort_unstable();
    }
}

/// Finds the casters that coincide: again when objects or meshes came, went or were exchanged. Those that coincide and
/// move together are kept; a caster that moves into another one is not found.
///
/// Set: `BuildSilhouettes`, after `update_posed_planes`. Reads [`Objects`]; writes [`CoincidentCasters`]. Cost: O(n log n)
/// when objects came or went, otherwise the casters that coincide and moved.
pub fn find_coincident_casters(
    mut coincident: ResMut<CoincidentCasters>,
    objects: Res<Objects>,
    casters: Query<CasterShape>,
    exchanged: Query<(), Changed<CasterEdges>>,
) {
    let coincident = &mut *coincident;
    if coincident.flags_generation != Some(objects.flags_generation) || !exchanged.is_empty() {
        coincident.flags_generation = Some(objects.flags_generation);
        coincident.find(&objects, &casters);
        return;
    }
    coincident.pairs.retain(|&(object, other)| {
        let moved = [object, other].map(|object| objects.moved.contains(object as usize));
        moved == [false; 2] || coincide(object, other, &objects, &casters)
    });
}

/// Whether two casters have the same triangles in the same place, and cast for the same lights. Posed meshes do not.
fn coincide(object: u32, other: u32, objects: &Objects, casters: &Query<CasterShape>) -> bool {
    let [object, other] = [object as usize, other as usize];
    if objects.layers[object] != objects.layers[other] {
        return false;
    }
    let [Ok(a), Ok(b)] = [object, other].map(|object| casters.get(objects.entities[object])) else {
        return false;
    };
    let count = |shape: &CasterShapeItem| shape.edges.0.edges.triangle_count();
    !a.is_posed()
        && !b.is_posed()
        && a.edges.0.fingerprint == b.edges.0.fingerprint
        && count(&a) == count(&b)
        && a.world_from_local() == b.world_from_local()
}
