//! The dense object index: which entity has which index, where it is, and what it takes part in.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_transform::prelude::GlobalTransform;
use fixedbitset::FixedBitSet;

use super::boxes::Boxes;
use super::work::SetWork;
use crate::scene::{PosedMesh, SceneMaterials, SelectionLayers, ShadowCaster, ShadowReceiver, WorldBounds};

/// Every entity with [`WorldBounds`], by dense index in ascending order of `Entity` (bevy's own order, which puts younger
/// entities first). Written by [`collect_objects`].
///
/// An object with empty bounds keeps its index but is in no set.
#[derive(Resource, Clone, Debug, Default)]
pub struct Objects {
    /// Entity of each index, ascending.
    pub entities: Vec<Entity>,
    /// World bounds of each index, padded.
    pub boxes: Boxes,
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
    /// Increases when indices change their meaning: an object was added or removed. Index by index caches end here.
    pub layout_generation: u64,
    /// Increases when layers, casters, receivers or drawn objects changed, and with `layout_generation`.
    pub flags_generation: u64,
    /// Objects with empty bounds.
    pub left_out: usize,
    /// Index of each entity, by the entity's own index; `u32::MAX` for none. An array, since entity indices are dense.
    index_of: Vec<u32>,
    /// Layers that all objects are on; all if there are no objects.
    pub(super) common_layers: u32,
    /// Rows of the last rebuild, kept for their allocation.
    rows: Vec<Row>,
    counts: Counts,
}

/// How many entities have what: a component removed and none added shows here, and nowhere else that lasts until we
/// look (removal events are dropped after two frames).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Counts {
    objects: usize,
    casters: usize,
    receivers: usize,
    drawn: usize,
    layered: usize,
}

/// All that a rebuild takes from one entity.
#[derive(Clone, Copy, Debug)]
struct Row {
    entity: Entity,
    layers: u32,
    aabb: crate::geometry::Aabb,
    caster: bool,
    receiver: bool,
    drawn: bool,
    moved: bool,
}

impl Objects {
    /// Number of indices.
    pub fn len(&self) -> usize {
        self.entities.len()
    }

    /// Whether there are no objects.
    pub fn is_empty(&self) -> bool {
        self.entities.is_empty()
    }

    /// The index of an entity; `None` if it is no object.
    pub fn index_of(&self, entity: Entity) -> Option<usize> {
        let &index = self.index_of.get(entity.index_u32() as usize)?;
        let index = index as usize;
        (self.entities.get(index) == Some(&entity)).then_some(index)
    }

    /// The words of a bitset in which an object moved, with the bits of those.
    pub(super) fn moved_words(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let words = self.moved.as_slice().iter().copied().enumerate();
        words.filter(|&(_, bits)| bits != 0)
    }

    fn rebuild(&mut self) {
        self.rows.sort_unstable_by_key(|row| row.entity);
        let same_layout = self.rows.len() == self.entities.len()
            && self
                .rows
                .iter()
                .zip(&self.entities)
                .all(|(row, &entity)| row.entity == entity);
        let len = self.rows.len();
        if !same_layout {
            self.layout_generation += 1;
            self.entities.clear();
            self.entities.extend(self.rows.iter().map(|row| row.entity));
            self.index_of.fill(u32::MAX);
            for (index, entity) in self.entities.iter().enumerate() {
                let slot = entity.index_u32() as usize;
                if self.index_of.len() <= slot {
                    self.index_of.resize(slot + 1, u32::MAX);
                }
                self.index_of[slot] = index as u32;
            }
            self.boxes.reset(len);
        }
        self.flags_generation += 1;
        self.layers.clear();
        self.layers.extend(self.rows.iter().map(|row| row.layers));
        self.common_layers = self
            .layers
            .iter()
            .fold(u32::MAX, |common, layers| common & layers);
        for set in [
            &mut self.present,
            &mut self.casters,
            &mut self.receivers,
            &mut self.drawn,
            &mut self.moved,
        ] {
            resize(set, len);
        }
        for (index, row) in self.rows.iter().enumerate() {
            self.boxes.set(index, &row.aabb);
            self.present.set(index, !row.aabb.is_empty());
            self.casters.set(index, row.caster);
            self.receivers.set(index, row.receiver);
            self.drawn.set(index, row.drawn);
            self.moved.set(index, row.moved);
        }
        self.left_out = len - self.present.count_ones(..);
    }
}

/// Clears a set and gives it exactly `len` bits.
pub(super) fn resize(set: &mut FixedBitSet, len: usize) {
    if set.len() != len {
        *set = FixedBitSet::with_capacity(len);
    } else {
        set.clear();
    }
}

/// All that [`collect_objects`] reads of one object.
type ObjectItem<'a> = (
    Entity,
    Ref<'a, WorldBounds>,
    Option<Ref<'a, GlobalTransform>>,
    Option<Ref<'a, PosedMesh>>,
    Option<&'a SelectionLayers>,
    Has<ShadowCaster>,
    Has<ShadowReceiver>,
    Has<SceneMaterials>,
);

/// Components that make an object a member of a set; one added changes the flags.
type FlagsChanged = (
    With<WorldBounds>,
    Or<(
        Added<WorldBounds>,
        Added<ShadowCaster>,
        Added<ShadowReceiver>,
        Added<SceneMaterials>,
        Changed<SelectionLayers>,
    )>,
);

/// Objects that have a component too; to be counted, by archetype.
type ObjectsWith<'w, 's, T> = Query<'w, 's, (), (With<WorldBounds>, With<T>)>;

/// What [`collect_objects`] counts.
#[derive(SystemParam)]
pub struct ObjectCounts<'w, 's> {
    casters: ObjectsWith<'w, 's, ShadowCaster>,
    receivers: ObjectsWith<'w, 's, ShadowReceiver>,
    drawn: ObjectsWith<'w, 's, SceneMaterials>,
    layered: ObjectsWith<'w, 's, SelectionLayers>,
}

/// Anything that moved an object.
type Moved = Or<(Changed<WorldBounds>, Changed<GlobalTransform>, Changed<PosedMesh>)>;

/// Brings [`Objects`] up to date.
///
/// Set: `CollectSets`, first. Reads [`WorldBounds`] and the marker components. With nothing changed it only compares
/// ticks; moved objects are written alone; an object or marker that came or went rebuilds all, O(n log n).
pub fn collect_objects(
    mut objects: ResMut<Objects>,
    mut work: ResMut<SetWork>,
    all: Query<ObjectItem<'static>>,
    flags_changed: Query<(), FlagsChanged>,
    moved: Query<(Entity, &WorldBounds), Moved>,
    members: ObjectCounts,
) {
    let counts = Counts {
        objects: all.iter().len(),
        casters: members.casters.iter().len(),
        receivers: members.receivers.iter().len(),
        drawn: members.drawn.iter().len(),
        layered: members.layered.iter().len(),
    };
    let objects = &mut *objects;
    if counts != objects.counts || !flags_changed.is_empty() {
        objects.counts = counts;
        objects.rows.clear();
        objects.rows.extend(all.iter().map(
            |(entity, bounds, transform, pose, layers, caster, receiver, drawn)| Row {
                entity,
                layers: layers.copied().unwrap_or_default().0,
                aabb: bounds.0,
                caster,
                receiver,
                drawn,
                moved: bounds.is_changed()
                    || transform.is_some_and(|transform| transform.is_changed())
                    || pose.is_some_and(|pose| pose.is_changed()),
            },
        ));
        objects.rebuild();
        work.layouts += 1;
        return;
    }
    if !objects.moved.is_clear() {
        objects.moved.clear();
    }
    for (entity, bounds) in &moved {
        let Some(index) = objects.index_of(entity) else {
            continue;
        };
        work.objects_written += 1;
        objects.boxes.set(index, &bounds.0);
        objects.moved.insert(index);
        let present = !bounds.0.is_empty();
        if objects.present.contains(index) != present {
            objects.present.set(index, present);
            objects.left_out = objects.len() - objects.present.count_ones(..);
        }
    }
}
