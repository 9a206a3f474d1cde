//! The state of a light's entity, before it becomes a light of the frame.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::Vec3;

use super::companion::CompanionOf;
use super::placing::Placed;
use crate::scene::{Light, LightModel, LightSelection, LightTextures};

/// The state of a light's entity in this frame.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub entity: Entity,
    /// The light that the entity completes, if it is a companion.
    pub companion_of: Option<CompanionOf>,
    /// Copy of the component.
    pub source: Light,
    /// The light with the range of its shadows.
    pub light: Light,
    pub world_from_light: GlobalTransform,
    pub selection: LightSelection,
    pub model: LightModel,
    pub textures: LightTextures,
    pub placed: Placed,
    /// Whether all of this but the textures is as it was in the frame before.
    pub is_kept: bool,
}

impl Candidate {
    /// The order of the light among those of the frame.
    pub fn order(&self) -> (Option<CompanionOf>, Entity) {
        (self.companion_of, self.entity)
    }

    /// Whether the light was placed by the same values.
    pub fn is_placed_by(
        &self,
        (companion_of, entity): (Option<CompanionOf>, Entity),
        source: &Light,
        world_from_light: &GlobalTransform,
        model: &LightModel,
    ) -> bool {
        self.order() == (companion_of, entity)
            && self.world_from_light == *world_from_light
            && self.source == *source
            && self.model == *model
    }
}

/// Whether a light gives no light at all.
pub(in crate::sets) fn is_dark(light: &Light) -> bool {
    light.intensity == 0.0 || light.color == Vec3::ZERO
}
