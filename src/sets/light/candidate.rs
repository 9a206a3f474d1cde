//! The state of a light's entity, before it becomes a light of the frame.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::Vec3;

use super::placing::Placed;
use crate::scene::{Light, LightModel, LightSelection, LightTextures};

/// The state of a light's entity in this frame.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub entity: Entity,
    pub light: Light,
    pub world_from_light: GlobalTransform,
    pub selection: LightSelection,
    pub model: LightModel,
    pub textures: LightTextures,
    pub placed: Placed,
}

/// Whether a light gives no light at all.
pub(in crate::sets) fn is_dark(light: &Light) -> bool {
    light.intensity == 0.0 || light.color == Vec3::ZERO
}
