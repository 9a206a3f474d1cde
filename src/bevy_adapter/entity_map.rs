//! Which entity of a mirror stands for which of the game.

use bevy::ecs::prelude::*;

/// From the game's entities to a mirror's: an array over the dense entity index, so that a walk over moved objects does
/// no hashing.
#[derive(Debug, Default)]
pub struct EntityMap {
    slots: Vec<(Entity, Entity)>,
}

const FREE: (Entity, Entity) = (Entity::PLACEHOLDER, Entity::PLACEHOLDER);

impl EntityMap {
    /// The entity of the mirror.
    pub fn get(&self, main: Entity) -> Option<Entity> {
        let &(known, mirrored) = self.slots.get(main.index_u32() as usize)?;
        (known == main && known != Entity::PLACEHOLDER).then_some(mirrored)
    }

    /// Keeps a pair, and gives back what stood at the same index: an entity of an earlier generation, whose end was not
    /// heard of.
    pub fn insert(&mut self, main: Entity, mirrored: Entity) -> Option<Entity> {
        let index = main.index_u32() as usize;
        if self.slots.len() <= index {
            self.slots.resize(index + 1, FREE);
        }
        let old = std::mem::replace(&mut self.slots[index], (main, mirrored));
        (old != FREE && old.0 != main).then_some(old.1)
    }

    /// Forgets an entity, and gives what stood for it.
    pub fn remove(&mut self, main: Entity) -> Option<Entity> {
        let mirrored = self.get(main)?;
        self.slots[main.index_u32() as usize] = FREE;
        Some(mirrored)
    }
}
