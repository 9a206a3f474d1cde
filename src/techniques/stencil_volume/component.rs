//! What a user sets on a light.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

/// Gives a light hard shadows by stencil shadow volumes. Area lights cast from their centre.
///
/// Exact for any triangle mesh, open or closed; alpha-tested surfaces cast whole. At most 127 volumes may stand one
/// behind the other at a pixel: the stencil counts modulo 128.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct StencilVolume {
    /// Which way intersections with the volumes are counted.
    pub counting: Counting,
    /// How far the volumes reach.
    pub extent: Extent,
}

/// Which way intersections with a shadow volume are counted. The pictures are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Counting {
    /// Towards the viewer (depth-pass, no caps) where the caster provably does not shadow the viewport, else away from
    /// it (depth-fail); decided for each caster.
    #[default]
    Auto,
    /// Always away from the viewer.
    DepthFail,
}

/// How far shadow volumes reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Extent {
    /// To just beyond what is seen of the receivers within the light's range, unless the light is within the caster's bounds
    /// or directional; then to infinity.
    #[default]
    Finite,
    /// To infinity.
    Infinite,
}
