//! Which part an entity takes in shadows, and which lights select it.

use bevy_ecs::prelude::*;

/// Blocks light. Blocking is two-sided: any triangle blocks, whichever way it faces.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadowCaster;

/// Shows shadows. A mesh without it is lit as if nothing stood before the light.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadowReceiver;

/// The layers an object is on; a light acts on it if [`LightSelection`](super::LightSelection) shares a bit.
/// An entity without it is on layer 0.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct SelectionLayers(pub u32);

impl Default for SelectionLayers {
    fn default() -> Self {
        Self(1)
    }
}
