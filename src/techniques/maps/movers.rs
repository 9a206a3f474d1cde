//! Which casters move, and when each moved last.

use bevy_ecs::prelude::Entity;
use fixedbitset::FixedBitSet;

use crate::sets::Objects;

/// When every object moved last, by dense index.
#[derive(Clone, Debug, Default)]
pub struct Movers {
    /// Objects that moved recently; they are drawn over the others.
    pub moving: FixedBitSet,
    /// Frame in which each object moved last.
    pub moved_at: Vec<u64>,
    /// Last frame in which an object moved, or began or ceased to count as moving.
    pub changed_at: u64,
    entities: Vec<Entity>,
    layout_generation: Option<u64>,
}

/// Where objects went when the dense index was rebuilt.
#[derive(Clone, Debug, Default)]
pub struct Remap {
    /// New index by old index; `None`: the object is gone.
    pub new_index: Vec<Option<u32>>,
    /// Number of new indices.
    pub len: usize,
}

impl Remap {
    /// Translates a set to the new indices. Also returns whether a member is gone.
    pub fn apply(&self, set: &FixedBitSet) -> (FixedBitSet, bool) {
        let mut mapped = FixedBitSet::with_capacity(self.len);
        let mut lost = false;
        for index in set.ones() {
            match self.new_index.get(index).copied().flatten() {
                Some(new) => mapped.insert(new as usize),
                None => lost = true,
            }
        }
        (mapped, lost)
    }
}

impl Movers {
    /// Brings the state up to date at frame `now`; `exchanged` are objects whose mesh or material changed.
    /// Returns the remap if the dense index was rebuilt.
    ///
    /// An object that appears after the first frame counts as moving, so a projectile causes no redraw of
    /// what stands still.
    pub fn update(
        &mut self,
        objects: &Objects,
        exchanged: impl Iterator<Item = usize>,
        now: u64,
        still_after: u32,
    ) -> Option<Remap> {
        let first = self.layout_generation.is_none();
        let remap = (self.layout_generation != Some(objects.layout_generation))
            .then(|| self.follow_layout(objects, now, first));
        if !first {
            for index in objects.moved.ones() {
                self.moved_at[index] = now;
                self.moving.insert(index);
                self.changed_at = now;
            }
        }
        for index in exchanged {
            self.moved_at[index] = now;
            self.changed_at = now;
        }
        if !self.moving.is_clear() {
            for index in 0..self.moved_at.len() {
                if self.moving.contains(index) && now - self.moved_at[index] >= u64::from(still_after.max(1))
                {
                    self.moving.remove(index);
                    self.changed_at = now;
                }
            }
        }
        remap
    }

    fn follow_layout(&mut self, objects: &Objects, now: u64, first: bool) -> Remap {
        let remap = Remap {
            new_index: self
                .entities
                .iter()
                .map(|&entity| objects.index_of(entity).map(|index| index as u32))
                .collect(),
            len: objects.len(),
        };
        let mut moved_at = vec![now; objects.len()];
        let mut known = FixedBitSet::with_capacity(objects.len());
        for (old, new) in remap.new_index.iter().enumerate() {
            if let Some(new) = *new {
                moved_at[new as usize] = self.moved_at[old];
                known.insert(new as usize);
            }
        }
        self.moving = remap.apply(&self.moving).0;
        if !first {
            known.toggle_range(..);
            self.moving.union_with(&known);
        }
        self.moved_at = moved_at;
        self.changed_at = now;
        self.entities.clone_from(&objects.entities);
        self.layout_generation = Some(objects.layout_generation);
        remap
    }
}
