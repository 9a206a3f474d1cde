//! Which objects may hide others from the camera and from lights.

use std::sync::Arc;

use bevy_ecs::prelude::*;

use super::MeshData;

/// Says whether an object may hide others; without it the object hides others if it is large, plain and opaque
/// ([`OcclusionSettings::auto`](crate::sets::OcclusionSettings::auto)).
///
/// Whatever it says, these never hide anything: objects with a surface that is blended or alpha-masked, posed meshes,
/// and meshes that cannot cast. From the camera only drawn objects hide others, from a light only its casters.
#[derive(Component, Clone, Debug, Default)]
pub enum Occluder {
    /// By its own triangles, however many these are.
    #[default]
    Own,
    /// By a simpler mesh in the same local space, wound outward. That it lies nowhere outside of the object is a promise:
    /// a mesh that breaks it hides what should show.
    Proxy(Arc<MeshData>),
    /// It hides nothing.
    Never,
}
