//! Changes of an object after which pictures of it are old.

use bevy_ecs::prelude::*;

use crate::scene::{LeftOutSubmeshes, SceneMaterials, SceneMesh};

/// Filter of objects whose mesh, materials or casting submeshes changed. Motion and poses are no part of it.
pub(crate) type Exchanged = Or<(
    Changed<SceneMesh>,
    Changed<SceneMaterials>,
    Changed<LeftOutSubmeshes>,
)>;
