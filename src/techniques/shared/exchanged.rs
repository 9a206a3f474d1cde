//! Changes of an object after which pictures of it are old.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::scene::changes::{Appearances, any_changed};
use crate::scene::{LeftOutSubmeshes, SceneMaterials, SceneMesh};

/// Filter of objects whose mesh, materials or casting submeshes changed. Motion and poses are no part of it.
type IsExchanged = Or<(
    Changed<SceneMesh>,
    Changed<SceneMaterials>,
    Changed<LeftOutSubmeshes>,
)>;

/// The objects whose mesh, materials or casting submeshes changed since the system last ran.
#[derive(SystemParam)]
pub struct Exchanged<'w, 's> {
    appearances: Appearances<'w, 's>,
    left_out: Query<'w, 's, Ref<'static, LeftOutSubmeshes>>,
    objects: Query<'w, 's, Entity, IsExchanged>,
}

impl Exchanged<'_, '_> {
    /// Lists the objects. The filter is asked only if something changed at all, which costs less to find out.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Entity> + '_ {
        let any = self.appearances.any_changed() || any_changed(&self.left_out);
        any.then(|| self.objects.iter()).into_iter().flatten()
    }
}
