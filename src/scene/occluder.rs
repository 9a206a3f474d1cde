//! Which objects may hide others from the camera and from lights.

use std::sync::Arc;

use bevy_ecs::prelude::*;

use super::MeshData;

/// Says whether an object may hide others. An object without this component hides others if it is large,
/// simple and opaque ([`OcclusionSettings::auto`](crate::sets::OcclusionSettings::auto)).
///
/// Regardless of this component, some objects never hide anything: objects with a blended or alpha-masked
/// surface, posed meshes, and meshes that cannot cast. Only drawn objects hide others from the camera, and
/// only a light's casters hide others from that light.
#[derive(Component, Clone, Debug, Default)]
pub enum Occluder {
    /// The object hides others with its own triangles, however many there are.
    #[default]
    Own,
    /// The object hides others with a simpler mesh in the same local space, wound outward. The user promises
    /// that this mesh lies nowhere outside the object. A mesh that breaks the promise hides objects that
    /// should be visible.
    Proxy(Arc<MeshData>),
    /// The object hides nothing.
    Never,
}
