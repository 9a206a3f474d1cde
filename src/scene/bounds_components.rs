//! Bounding boxes of objects in local and world space, as components.

use bevy_ecs::prelude::*;

use super::churn::count_churn;
use crate::geometry::Aabb;

/// Bounds of an object's mesh in its current pose, local space. They are empty for a mesh without triangles
/// or without finite positions.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct LocalBounds(pub Aabb);

impl Default for LocalBounds {
    fn default() -> Self {
        Self(Aabb::EMPTY)
    }
}

/// Bounds in local space that hold what an object's mesh does not: vertices that a shader displaces, such as those of water,
/// wind or terrain. The object is culled, lit and shadowed within its mesh's bounds and these. Its shadow stays that of the
/// mesh.
///
/// In Bevy the `Aabb` of an entity with `NoAutoAabb` counts as this component.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct ExtraBounds(pub Aabb);

/// Bounds of an object in world space. They are empty for an object that is left out because it has no
/// triangles, or because its transform leaves no area or is not finite.
///
/// A change of this component means that the object moved.
/// [`update_world_bounds`](super::update_world_bounds) marks the component as changed whenever the transform
/// or the local bounds changed, even if the box stays equal.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[component(on_add = count_churn, on_remove = count_churn)]
pub struct WorldBounds(pub Aabb);

impl Default for WorldBounds {
    fn default() -> Self {
        Self(Aabb::EMPTY)
    }
}
