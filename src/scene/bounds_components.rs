//! Boxes of objects in local and world space, as components.

use bevy_ecs::prelude::*;

use super::churn::count_churn;
use crate::geometry::Aabb;

/// Bounds of the mesh as posed, local space. Empty for a mesh without triangles or finite positions.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct LocalBounds(pub Aabb);

impl Default for LocalBounds {
    fn default() -> Self {
        Self(Aabb::EMPTY)
    }
}

/// Bounds in world space. Empty for an object that is left out: no triangles, or a transform that is not
/// finite or singular.
///
/// Its change stands for the object having moved: [`update_world_bounds`](super::update_world_bounds) marks it whenever the transform or the local
/// bounds changed, whether or not the box came out the same.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[component(on_add = count_churn, on_remove = count_churn)]
pub struct WorldBounds(pub Aabb);

impl Default for WorldBounds {
    fn default() -> Self {
        Self(Aabb::EMPTY)
    }
}
