//! The dense object index: which entity has which index, where it is, and which roles it has.

use bevy_ecs::entity::EntityGeneration;
use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;

use super::boxes::{Boxes, GROUPS, Group, LANES, WORD};
use super::clusters::{Clusters, around, for_bits};
use super::spatial_order::spatial_order;
use crate::geometry::Aabb;
use crate::scene::tasks;

/// Every entity with [`WorldBounds`](crate::scene::WorldBounds), by dense index. Written by
/// [`collect_objects`](crate::sets::collect_objects()).
///
/// Indices are in *spatial* order. Each 64 that share a word of the bitsets are neighbours, and ascend by
/// `Entity` (bevy's own order, which puts younger entities first). So up to 64 objects ascend throughout, but
/// more than 64 do not; [`Objects::index_of`] finds an entity's index. The order lasts until objects come or
/// go, or until motion has spoilt it ([`Objects::layout_generation`] then increases).
///
/// An object with empty bounds keeps its index but is in no set.
#[derive(Resource, Clone, Debug, Default)]
pub struct Objects {
    /// Entity of each index.
    pub entities: Vec<Entity>,
    /// World bounds of each index, padded.
    pub boxes: Boxes,
    /// Boxes around each word of `boxes`, and around each block of words.
    pub clusters: Clusters,
    /// Selection layers of each index.
    pub layers: Vec<u32>,
    /// Objects whose bounds are not empty.
    pub present: FixedBitSet,
    /// Objects that block light.
    pub casters: FixedBitSet,
    /// Objects that show shadows.
    pub receivers: FixedBitSet,
    /// Objects that are drawn.
    pub drawn: FixedBitSet,
    /// Objects whose bounds, transform or pose changed in this frame.
    pub moved: FixedBitSet,
    /// Words of `moved` that are not 0.
    pub moved_words: FixedBitSet,
    /// Number of frames so far. `moved` is that of the last one.
    pub frame: u64,
    /// Increases when indices change their meaning, because an object was added or removed or because all
    /// were put into a new order. Caches by index are then invalid.
    pub layout_generation: u64,
    /// Increases when layers, casters, receivers or drawn objects changed, and whenever `layout_generation`
    /// does.
    pub flags_generation: u64,
    /// Number of objects with empty bounds.
    pub left_out: usize,
    /// Dense index of each entity, by the entity's own index. An array suffices, because entity indices are
    /// dense.
    slots: Vec<Slot>,
    /// Layers that all objects are on; all layers if there are no objects.
    pub(in crate::sets) common_layers: u32,
    /// World bounds of each index as the entities have them, without padding.
    pub(in crate::sets) bounds: Vec<Aabb>,
    /// Rows of the last rebuild, kept for their allocation.
    pub(in crate::sets) rows: Vec<Row>,
    pub(in crate::sets) decay: Decay,
    /// Counts of the last frame.
    pub(in crate::sets) counts: Option<Counts>,
}

/// The object that an entity index belongs to. The generation is kept here, so that iterating over entities
/// in their own order does not jump about in `entities`. Those jumps took half of the time for moving
/// objects.
#[derive(Clone, Copy, Debug)]
struct Slot {
    generation: EntityGeneration,
    index: u32,
}

impl Slot {
    const NONE: Self = Self {
        generation: EntityGeneration::FIRST,
        index: u32::MAX,
    };
}

/// The data that a rebuild takes from one entity.
#[derive(Clone, Copy, Debug)]
pub(in crate::sets) struct Row {
    pub entity: Entity,
    pub layers: u32,
    pub aabb: Aabb,
    pub caster: bool,
    pub receiver: bool,
    pub drawn: bool,
    pub moved: bool,
}

/// How many entities have which component. Hooks count components that come and go
/// ([`ObjectChurn`](crate::scene::ObjectChurn)), but a world whose entities are all cleared at once runs no
/// hooks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::sets) struct Counts {
    pub churn: u64,
    pub objects: usize,
    pub casters: usize,
    pub receivers: usize,
    pub drawn: usize,
    pub layered: usize,
}

/// How much the spatial order has suffered from motion.
#[derive(Clone, Copy, Debug)]
pub(in crate::sets) struct Decay {
    /// [`Clusters::cost`] of the order when it was new.
    fresh: f64,
    /// [`Clusters::cost`] of the order when a new order was requested.
    poor: Option<f64>,
    /// Frames with motion since the order was new.
    frames: u32,
    /// Least number of frames with motion before a new order.
    wait: u32,
}

impl Default for Decay {
    fn default() -> Self {
        Self {
            fresh: 0.0,
            poor: None,
            frames: 0,
            wait: Self::SHORTEST,
        }
    }
}

/// Cost, relative to that of the new order, from which objects are ordered again. By then lights test about
/// twice as many objects as they need to.
const POOR: f64 = 2.0;

impl Decay {
    /// Least wait, in frames with motion. A new order costs about as much as ten frames of motion, which is
    /// hardly noticeable when spread over this many.
    const SHORTEST: u32 = 120;
    /// Longest wait, in frames with motion, for orders that do not help. Objects that grew, for example,
    /// overlap in any order.
    const LONGEST: u32 = 1 << 14;

    /// Records a frame with motion.
    fn after_motion(&mut self, clusters: &Clusters) {
        self.frames += 1;
        if self.frames >= self.wait && clusters.words.len() > 1 {
            let cost = clusters.cost();
            self.poor = (cost > self.fresh * POOR).then_some(cost);
        }
    }

    /// Whether a new order is due.
    pub(in crate::sets) fn is_due(&self) -> bool {
        self.poor.is_some()
    }

    /// Records that the order was renewed.
    fn renewed(&mut self, clusters: &Clusters) {
        self.fresh = clusters.cost();
        self.wait = match self.poor.take() {
            Some(poor) if self.fresh > poor * 0.75 => (self.wait * 2).min(Self::LONGEST),
            _ => Self::SHORTEST,
        };
        self.frames = 0;
    }
}

/// Number of words that one task processes.
const CHUNK: usize = 64;

impl Objects {
    /// Number of indices.
    pub fn len(&self) -> usize {
        self.entities.len()
    }

    /// Whether there are no objects.
    pub fn is_empty(&self) -> bool {
        self.entities.is_empty()
    }

    /// The dense index of an entity. `None` if the entity is no object.
    pub fn index_of(&self, entity: Entity) -> Option<usize> {
        let slot = self.slots.get(entity.index_u32() as usize)?;
        let held = slot.index != u32::MAX && slot.generation == entity.generation();
        held.then_some(slot.index as usize)
    }

    /// Layers that all objects are on; all layers if there are no objects.
    pub fn common_layers(&self) -> u32 {
        self.common_layers
    }

    /// Bits of those objects of a word whose layers share a bit with the mask.
    pub(in crate::sets) fn selected(&self, word: usize, bits: usize, mask: u32) -> usize {
        if self.common_layers & mask != 0 {
            return bits;
        }
        let mut result = 0;
        for_bits(bits, |lane| {
            if self.layers[word * WORD + lane] & mask != 0 {
                result |= 1 << lane;
            }
        });
        result
    }

    /// Whether any object moved in this frame.
    pub fn any_moved(&self) -> bool {
        !self.moved_words.is_clear()
    }

    /// Clears the record of which objects moved.
    pub(in crate::sets) fn begin_motion(&mut self) {
        if self.any_moved() {
            self.moved.clear();
            self.moved_words.clear();
        }
    }

    /// Writes the boxes of moved objects, and refits the clusters around them.
    pub(in crate::sets) fn end_motion(&mut self) {
        for (word, bits) in self.moved.as_slice().iter().enumerate() {
            if *bits != 0 {
                self.moved_words.insert(word);
            }
        }
        if self.any_moved() {
            self.write_boxes(false);
            self.decay.after_motion(&self.clusters);
        }
    }

    /// Takes over all rows. The order stays the same if `same_order` and the rows are the same entities;
    /// otherwise a new order is found.
    pub(in crate::sets) fn rebuild(&mut self, same_order: bool) {
        self.rows.sort_unstable_by_key(|row| row.entity);
        let len = self.rows.len();
        let known = |row: &Row| self.index_of(row.entity).is_some();
        let same_layout = same_order && len == self.len() && self.rows.iter().all(known);
        let mut order;
        if same_layout {
            order = vec![0; len];
            for (row, at) in self.rows.iter().zip(0..) {
                let slot = self.slots[row.entity.index_u32() as usize];
                order[slot.index as usize] = at;
            }
        } else {
            order = spatial_order(self.rows.iter().map(|row| row.aabb));
            self.layout_generation += 1;
            self.entities.clear();
            let entities = order.iter().map(|&at| self.rows[at as usize].entity);
            self.entities.extend(entities);
            self.slots.fill(Slot::NONE);
            for (entity, index) in self.entities.iter().zip(0..) {
                let slot = entity.index_u32() as usize;
                if self.slots.len() <= slot {
                    self.slots.resize(slot + 1, Slot::NONE);
                }
                self.slots[slot] = Slot {
                    generation: entity.generation(),
                    index,
                };
            }
            self.boxes.reset(len);
            self.clusters.reset(len);
        }
        self.flags_generation += 1;
        for set in [
            &mut self.present,
            &mut self.casters,
            &mut self.receivers,
            &mut self.drawn,
            &mut self.moved,
        ] {
            resize(set, len);
        }
        resize(&mut self.moved_words, len.div_ceil(WORD));
        self.layers.clear();
        self.bounds.clear();
        self.common_layers = u32::MAX;
        for (index, &at) in order.iter().enumerate() {
            let row = &self.rows[at as usize];
            self.layers.push(row.layers);
            self.bounds.push(row.aabb);
            self.common_layers &= row.layers;
            self.casters.set(index, row.caster);
            self.receivers.set(index, row.receiver);
            self.drawn.set(index, row.drawn);
            self.moved.set(index, row.moved);
            if row.moved {
                self.moved_words.insert(index / WORD);
            }
        }
        self.write_boxes(true);
        if !same_layout {
            self.decay.renewed(&self.clusters);
        }
    }

    /// Updates `boxes`, `clusters` and `present` from `bounds`, for all objects or for those that moved.
    fn write_boxes(&mut self, all: bool) {
        let pieces = self
            .boxes
            .groups
            .chunks_mut(CHUNK * GROUPS)
            .zip(self.clusters.words.groups.chunks_mut(CHUNK / LANES))
            .zip(self.present.as_mut_slice().chunks_mut(CHUNK))
            .zip(self.moved.as_slice().chunks(CHUNK))
            .zip(self.bounds.chunks(CHUNK * WORD));
        let parallel = all || self.moved_words.count_ones(..) > 2 * CHUNK;
        tasks::for_each(
            pieces,
            parallel,
            |((((groups, clusters), present), moved), bounds)| {
                for (word, (present, &moved)) in present.iter_mut().zip(moved).enumerate() {
                    let moved = if all { usize::MAX } else { moved };
                    if moved == 0 {
                        continue;
                    }
                    let groups = &mut groups[word * GROUPS..][..GROUPS];
                    let bounds = &bounds[word * WORD..];
                    *present = write_word(groups, &bounds[..bounds.len().min(WORD)], moved);
                    clusters[word / LANES].set(word % LANES, &around(groups));
                }
            },
        );
        self.clusters.refit_blocks();
        self.left_out = self.len() - self.present.count_ones(..);
    }
}

/// Writes the boxes of a word. Returns the bits of those that are present.
fn write_word(groups: &mut [Group], bounds: &[Aabb], moved: usize) -> usize {
    let mut present = 0;
    for (at, group) in groups.iter_mut().enumerate() {
        let lanes = moved >> (at * LANES) & 0xff;
        let first = (at * LANES).min(bounds.len());
        let held = (bounds.len() - first).min(LANES);
        if lanes != 0 && held > 0 {
            let held_lanes = 0xff >> (LANES - held);
            group.write(&bounds[first..][..held], lanes & held_lanes);
        }
        present |= group.present() << (at * LANES);
    }
    present
}

/// Clears a set and gives it exactly `len` bits.
pub(in crate::sets) fn resize(set: &mut FixedBitSet, len: usize) {
    if set.len() != len {
        *set = FixedBitSet::with_capacity(len);
    } else {
        set.clear();
    }
}
