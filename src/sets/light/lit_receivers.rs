//! Lists where the visible receivers of a light are, as boxes against which casters are tested.

use fixedbitset::FixedBitSet;
use glam::Vec3;

use super::frame_light::{FrameLight, LightScratch};
use super::illumination::showing;
use crate::geometry::{Aabb, LightHull};
use crate::sets::index::boxes::WORD;
use crate::sets::index::clusters::bits_of;
use crate::sets::index::objects::Objects;
use crate::sets::view::visible_parts::VisibleParts;

/// Up to this many receivers are listed one by one, regardless of the cost.
const FEW: usize = 64;

/// At most this many receivers are listed one by one.
const MANY: usize = 256;

/// Limit on the tests of one light, each of a word of casters against a receiver. Where the limit and [`FEW`]
/// are exceeded, receivers are joined.
const MAX_TESTS: usize = 1024;

/// Number of cells along each axis of the grid that joins receivers.
const GRID: usize = 4;

/// Lists boxes that hold every visible point of the light's receivers within the box of the light's volume.
/// There is one box for each receiver or, if there are many receivers, one for each cell of a grid. No box is
/// empty.
pub(in crate::sets) fn list_lit_receivers(light: &mut FrameLight, parts: &VisibleParts, objects: &Objects) {
    let mut boxes = std::mem::take(&mut light.region.lit_receivers);
    boxes.clear();
    let words = words_of_s(light);
    let reach = light.lit.aabb();
    let words_showing = || {
        let touched = light.scratch.touched.ones();
        touched
            .map(|word| (word, showing(light, objects, word)))
            .filter(|(_, receivers)| *receivers != 0)
    };
    let lit = words_showing()
        .flat_map(|(word, receivers)| bits_of(receivers).map(move |bit| word * WORD + bit))
        .map(|receiver| parts.get(objects, receiver).intersection(reach));
    let counts = words_showing().map(|(_, receivers)| receivers.count_ones() as usize);
    let count: usize = counts.sum();
    if count <= FEW || (count <= MANY && count * words <= MAX_TESTS) {
        // Capacity grows in two steps, so that frames soon allocate nothing.
        boxes.reserve(if count <= FEW { FEW } else { MANY });
        boxes.extend(lit.filter(|part| !part.is_empty()));
    } else if parts.in_use() {
        join(lit, &light.region.receiver_bounds, &mut boxes);
    } else {
        // Neighbours share a word, and thus a box.
        let lit = words_showing().map(|(word, _)| objects.clusters.words.get(word).intersection(reach));
        join(lit, &light.region.receiver_bounds, &mut boxes);
    }
    light.region.lit_receivers = boxes;
}

/// Joins boxes whose centres are in the same cell of a grid over `bounds`.
fn join(boxes: impl Iterator<Item = Aabb>, bounds: &Aabb, joined: &mut Vec<Aabb>) {
    joined.resize(GRID.pow(3), Aabb::EMPTY);
    let size = (bounds.max - bounds.min).max(Vec3::splat(1e-6));
    for part in boxes.filter(|part| !part.is_empty()) {
        let cell = (part.center() - bounds.min) / size * GRID as f32;
        let [x, y, z] = cell
            .clamp(Vec3::ZERO, Vec3::splat(GRID as f32 - 1.0))
            .to_array()
            .map(|at| at as usize);
        let cell = &mut joined[(x * GRID + y) * GRID + z];
        *cell = cell.union(part);
    }
    joined.retain(|cell| !cell.is_empty());
}

/// Removes from S the casters that stand between the light and none of the listed boxes.
///
/// This happens only if something occludes. In open scenes receivers see the light from all around, and the
/// hulls cost more than they save.
pub(in crate::sets) fn cut_casters(light: &mut FrameLight, parts: &VisibleParts, objects: &Objects) {
    if !parts.in_use() || light.region.lit_receivers.len() * words_of_s(light) > 4 * MAX_TESTS {
        return;
    }
    let LightScratch { touched, kept, .. } = &mut light.scratch;
    if kept.len() != light.sets.s.len() {
        *kept = FixedBitSet::with_capacity(light.sets.s.len());
    }
    let (s, kept) = (light.sets.s.as_mut_slice(), kept.as_mut_slice());
    touched.ones().for_each(|word| kept[word] = 0);
    for part in &light.region.lit_receivers {
        let hull = LightHull::of_aabb(part, &light.emitter);
        for word in touched.ones() {
            let open = s[word] & !kept[word];
            if open != 0 {
                kept[word] |= objects.boxes.touching_planes(word, open, &hull.planes);
            }
        }
    }
    touched.ones().for_each(|word| s[word] &= kept[word]);
}

/// Number of words of S that hold a caster.
fn words_of_s(light: &FrameLight) -> usize {
    let s = light.sets.s.as_slice();
    light.scratch.touched.ones().filter(|&word| s[word] != 0).count()
}
