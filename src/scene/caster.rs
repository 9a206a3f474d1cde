//! Which part an entity takes in shadows, and which lights select it.

use bevy_ecs::prelude::*;

use super::churn::count_churn;

/// Blocks light. Blocking is two-sided: any triangle blocks, whichever way it faces.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(on_add = count_churn, on_remove = count_churn)]
pub struct ShadowCaster;

/// Shows shadows. A mesh without it is lit as if nothing stood before the light.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(on_add = count_churn, on_remove = count_churn)]
pub struct ShadowReceiver;

/// The layers an object is on; a light acts on it if [`LightSelection`](super::LightSelection) shares a bit.
/// An entity without it is on layer 0.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(on_add = count_churn, on_remove = count_churn)]
pub struct SelectionLayers(pub u32);

impl Default for SelectionLayers {
    fn default() -> Self {
        Self(1)
    }
}

/// Which faces of surfaces are drawn. Shadows do not depend on it: any triangle blocks light, whichever way it faces.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaceCulling {
    /// Materials that are not double-sided show their front faces only.
    #[default]
    SingleSided,
    /// Every surface is seen from both sides.
    None,
}
