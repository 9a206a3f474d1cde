//! Whether an entity blocks light, shows shadows, and is selected by a light.

use bevy_ecs::prelude::*;
use smallvec::SmallVec;

use super::churn::count_churn;

/// Marks an entity that blocks light. Blocking is two-sided: any triangle blocks, whichever way it faces. The exceptions are
/// submeshes that the view culls as a whole ([`CulledCasters`]) and those that alpha hides everywhere.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(on_add = count_churn, on_remove = count_churn)]
pub struct ShadowCaster;

/// Indices of submeshes, ascending.
pub(crate) type Submeshes = SmallVec<[u32; 2]>;

/// The submeshes of an object that cast nothing, because alpha hides them or the view culls them ([`CulledCasters`]), while
/// others do. Written by [`leave_out_submeshes`](crate::sets::leave_out_submeshes). Casters without the component cast as a
/// whole.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq)]
pub struct LeftOutSubmeshes(pub(crate) Submeshes);

impl LeftOutSubmeshes {
    /// The indices of the submeshes, ascending.
    pub fn indices(&self) -> &[u32] {
        &self.0
    }
}

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
/// whichever way it faces, unless a whole object or submesh is culled ([`CulledCasters`]). Default: single-sided.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaceCulling {
    /// Materials that are not double-sided show their front faces only.
    #[default]
    SingleSided,
    /// Every surface is seen from both sides.
    None,
}

/// Whether objects and submeshes that are culled from the view as a whole cast shadows.
///
/// This concerns closed meshes and submeshes that are turned inside out, with materials that show their front faces only, seen
/// from outside of the object's bounds: their near side is not drawn. Outline hulls are built this way, a little larger than
/// the object in them; if the hull cast, the whole object would lie in its shadow. So are rooms that the camera looks into
/// from above. Under [`FaceCulling::None`] nothing is culled, and everything casts.
///
/// It is left out for all lights, also those within it. A hull that shares a submesh with the object which it outlines is
/// not found.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CulledCasters {
    /// Surfaces that are culled from the view cast no shadow, so light passes where the viewer sees through. This is
    /// the default.
    #[default]
    LeaveOut,
    /// Everything casts.
    Cast,
}
