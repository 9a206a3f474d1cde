//! Finds objects and submeshes that nobody can see because of their alpha. They cast no shadow, and such objects are not
//! drawn.

use std::collections::HashMap;
use std::sync::{Arc, Weak};

use bevy_ecs::prelude::*;

use crate::scene::changes::NewAppearances;
use crate::scene::material::Hidden;
use crate::scene::{ObjectChurn, SceneMaterials, SceneMesh, Submeshes, Texture, WorldBounds};

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
/// Set: `CollectSets`, before the objects. Cost: all objects where one came, went or exchanged its mesh or material; a texture
/// is examined once, and only if a material masks or blends by it.
pub fn find_invisible_objects(
    mut found: ResMut<InvisibleObjects>,
    mut churn: ResMut<ObjectChurn>,
    objects: Query<(Entity, &SceneMesh, &SceneMaterials), With<WorldBounds>>,
    mut appearances: NewAppearances,
) {
    let found = &mut *found;
    let exchanged = appearances.take();
    if found.seen == Some(churn.0) && !exchanged {
        return;
    }
    found.alphas.retain(|_, (texture, _)| texture.strong_count() > 0);
    let before = std::mem::take(&mut found.entities);
    let mut entities = Vec::new();
    let mut parts = std::mem::take(&mut found.parts);
    parts.clear();
    for (entity, mesh, materials) in &objects {
        match materials.hidden(&mesh.0, |texture| found.greatest_alpha(texture)) {
            Hidden::Nothing => {}
            Hidden::Submeshes(hidden) => parts.push((entity, hidden)),
            Hidden::Everything => entities.push(entity),
        }
    }
    entities.sort_unstable();
    parts.sort_unstable();
    if entities != before {
        churn.0 += 1; // the objects are collected anew
    }
    found.entities = entities;
    found.parts = parts;
    found.seen = Some(churn.0);
}
