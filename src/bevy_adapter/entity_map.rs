//! The map from the game's entities to the entities of a mirror.

use bevy::ecs::prelude::*;

/// Map from the game's entities to the entities of a mirror. It is an array over the dense entity index, so
/// that a walk over moved objects does no hashing.
#[derive(Debug, Default)]
pub struct EntityMap {
    slots: Vec<(Entity, Entity)>,
}

const FREE: (Entity, Entity) = (Entity::PLACEHOLDER, Entity::PLACEHOLDER);

impl EntityMap {
    /// Returns the mirror's entity for an entity of the game.
    pub fn get(&self, main: Entity) -> Option<Entity> {
        let &(known, mirrored) = self.slots.get(main.index_u32() as usize)?;
        (known == main && known != Entity::PLACEHOLDER).then_some(mirrored)
    }

    /// Stores a pair. Returns the mirror's entity that was stored for an earlier generation of the same
    /// index; its removal was missed, and the caller must despawn it.
    pub fn insert(&mut self, main: Entity, mirrored: Entity) -> Option<Entity> {
        let index = main.index_u32() as usize;
        if self.slots.len() <= index {
            self.slots.resize(index + 1, FREE);
        }
        let old = std::mem::replace(&mut self.slots[index], (main, mirrored));
        (old != FREE && old.0 != main).then_some(old.1)
    }

    /// Removes an entity of the game, and returns the mirror's entity for it.
    pub fn remove(&mut self, main: Entity) -> Option<Entity> {
        let mirrored = self.get(main)?;
        self.slots[main.index_u32() as usize] = FREE;
        Some(mirrored)
    }
}
