//! Whether an entity blocks light, shows shadows, and is selected by a light.

use bevy_ecs::prelude::*;

use super::churn::count_churn;

/// Marks an entity that blocks light. Blocking is two-sided: any triangle blocks, whichever way it faces. The one
/// exception are objects that the view culls as a whole ([`CulledCasters`]).
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(on_add = count_churn, on_remove = count_churn)]
pub struct ShadowCaster;

/// Marks an entity that shows shadows. A mesh without it is lit as if nothing stood before the light.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(on_add = count_churn, on_remove = count_churn)]
pub struct ShadowReceiver;

/// The selection layers of an object, one a bit. A light acts on the object if its
/// [`LightSelection`](super::LightSelection) shares a bit. An object without this component is on layer 0,
/// which is the bit of value 1.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(on_add = count_churn, on_remove = count_churn)]
pub struct SelectionLayers(pub u32);

impl Default for SelectionLayers {
    fn default() -> Self {
        Self(1)
    }
}

/// Which faces of surfaces are drawn. Shadows do not depend on it, because any triangle blocks light,
/// whichever way it faces, unless the whole object is culled ([`CulledCasters`]).
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaceCulling {
    /// Materials that are not double-sided show their front faces only.
    #[default]
    SingleSided,
    /// Every surface is seen from both sides.
    None,
}

/// Whether objects that are culled from the view as a whole cast shadows.
///
/// Such an object is a closed mesh that is turned inside out, with materials that show their front faces only, seen from
/// outside of its bounds: its near side is not drawn. Outlines are made so, by a hull that is a little larger than the
/// object in it; if the hull cast, the whole object would lie in its shadow. Rooms are made so as well, which are looked
/// into from above. Under [`FaceCulling::None`] nothing is culled, and everything casts.
///
/// An object is left out for all lights, also those within it. A hull that belongs to the mesh of the object which it
/// outlines, as a further submesh, is not found.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CulledCasters {
    /// Surfaces that are culled from the view cast no shadow, so light passes where the viewer sees through. This is
    /// the default.
    #[default]
    LeaveOut,
    /// Everything casts.
    Cast,
}
