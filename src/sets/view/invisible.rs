//! Finds objects and submeshes that nobody can see because of their alpha. They cast no shadow, and such objects are not
//! drawn.

use std::collections::HashMap;
use std::sync::{Arc, Weak};

use bevy_ecs::prelude::*;

use crate::scene::changes::NewAppearances;
use crate::scene::material::Hidden;
use crate::scene::{ObjectChurn, SceneMaterials, SceneMesh, Submeshes, Texture, WorldBounds};

/// An object and what decides whether it can be seen.
type Appearance = (Entity, &'static SceneMesh, &'static SceneMaterials);

/// Objects and submeshes whose materials hide every triangle. Written by [`find_invisible_objects`].
#[derive(Resource, Debug, Default)]
pub struct InvisibleObjects {
    /// Ascending.
    entities: Vec<Entity>,
    /// The hidden submeshes of objects that also have others, ascending by entity.
    parts: Vec<(Entity, Submeshes)>,
    /// The greatest alpha of textures, by their address.
    alphas: HashMap<usize, (Weak<Texture>, f32)>,
    seen: Option<u64>,
}

impl InvisibleObjects {
    /// Whether an object is invisible in this frame.
    pub fn contains(&self, entity: Entity) -> bool {
        self.entities.binary_search(&entity).is_ok()
    }

    /// The hidden submeshes of objects that also have others, ascending by entity.
    pub(in crate::sets) fn parts(&self) -> &[(Entity, Submeshes)] {
        &self.parts
    }

    fn greatest_alpha(&mut self, texture: &Arc<Texture>) -> f32 {
        let address = Arc::as_ptr(texture) as usize;
        if let Some((known, alpha)) = self.alphas.get(&address)
            && known.upgrade().is_some_and(|known| Arc::ptr_eq(&known, texture))
        {
            return *alpha;
        }
        let alpha = texture.greatest_alpha();
        self.alphas.insert(address, (Arc::downgrade(texture), alpha));
        alpha
    }
}

/// Finds the objects and submeshes that are invisible: blended with an alpha of 0, or masked with an alpha below the cutoff everywhere.
///
/// Set: `CollectSets`, before the objects. Cost: all objects where one came or went, and otherwise those that exchanged their
/// mesh or material; a texture is examined once, and only if a material masks or blends by it.
pub fn find_invisible_objects(
    mut found: ResMut<InvisibleObjects>,
    mut churn: ResMut<ObjectChurn>,
    objects: Query<Appearance, With<WorldBounds>>,
    mut appearances: NewAppearances,
) {
    let found = &mut *found;
    let exchanges = appearances.take();
    let same_objects = found.seen == Some(churn.0);
    if same_objects && exchanges.is_none() {
        return;
    }
    found.alphas.retain(|_, (texture, _)| texture.strong_count() > 0);
    let changed = match exchanges.few().filter(|_| same_objects) {
        Some(entities) => entities.iter().fold(false, |changed, &entity| {
            found.look_again(entity, objects.get(entity).ok()) | changed
        }),
        None => found.look_at_all(&objects),
    };
    if changed {
        churn.0 += 1; // the objects are collected anew
    }
    found.seen = Some(churn.0);
}

impl InvisibleObjects {
    fn hidden(&mut self, (_, mesh, materials): (Entity, &SceneMesh, &SceneMaterials)) -> Hidden {
        materials.hidden(&mesh.0, |texture| self.greatest_alpha(texture))
    }

    /// Lists all objects anew. Returns whether other objects are invisible.
    fn look_at_all(&mut self, objects: &Query<Appearance, With<WorldBounds>>) -> bool {
        let mut entities = Vec::new();
        let mut parts = std::mem::take(&mut self.parts);
        parts.clear();
        for object in objects {
            match self.hidden(object) {
                Hidden::Nothing => {}
                Hidden::Submeshes(hidden) => parts.push((object.0, hidden)),
                Hidden::Everything => entities.push(object.0),
            }
        }
        entities.sort_unstable();
        parts.sort_unstable();
        self.parts = parts;
        let before = std::mem::replace(&mut self.entities, entities);
        before != self.entities
    }

    /// Lists one object anew, or removes it if it has no appearance. Returns whether it became invisible or visible.
    fn look_again(&mut self, entity: Entity, object: Option<(Entity, &SceneMesh, &SceneMaterials)>) -> bool {
        let hidden = object.map_or(Hidden::Nothing, |object| self.hidden(object));
        let (at, was_listed) = match self.entities.binary_search(&entity) {
            Ok(at) => (at, true),
            Err(at) => (at, false),
        };
        let is_invisible = hidden == Hidden::Everything;
        match (was_listed, is_invisible) {
            (true, false) => {
                self.entities.remove(at);
            }
            (false, true) => self.entities.insert(at, entity),
            _ => {}
        }
        let at = self.parts.partition_point(|(listed, _)| *listed < entity);
        if self.parts.get(at).is_some_and(|(listed, _)| *listed == entity) {
            self.parts.remove(at);
        }
        if let Hidden::Submeshes(hidden) = hidden {
            self.parts.insert(at, (entity, hidden));
        }
        was_listed != is_invisible
    }
}
