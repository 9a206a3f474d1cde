//! The component that gives a light stencil shadow volumes.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

/// Gives a light hard shadows by stencil shadow volumes. Area lights cast from their centre.
///
/// Shadows are exact for any triangle mesh, open or closed. Alpha-tested surfaces cast whole.
///
/// The stencil counts to 127. At most 127 sheets of one caster may lie one behind the other; a caster that may have
/// more is reported ([`Reports`](crate::reports::Reports)). For a closed caster the limit is 63 while the light or the
/// camera is within its bounds, because then fronts and backs both count.
/// There may be any number of casters: from 127 sheets on they are counted in rounds of [`MOST_STACKED`], each of
/// which costs one cheap pass over the light's pixels.
/// [`Silhouette::stacked`](crate::silhouettes::Silhouette::stacked) is the number of sheets of a caster, estimated
/// from the boxes of its pieces.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StencilVolume {
    /// Direction in which intersections with the volumes are counted; it affects the time, not the picture.
    /// Default: automatic.
    pub counting: Counting,
    /// How far the volumes reach. Default: finite, which fills fewer pixels.
    pub extent: Extent,
}

/// The greatest number of sheets that one round of counting may add to the stencil.
pub const MOST_STACKED: u32 = 127;

/// Direction in which intersections with a shadow volume are counted. The pictures are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Counting {
    /// Decides for each caster. Where the caster provably does not shadow the viewport, volumes are counted
    /// towards the viewer (depth-pass), which needs no near cap and often no far cap. Elsewhere they are
    /// counted away from the viewer (depth-fail).
    #[default]
    Auto,
    /// Always counts away from the viewer. Volumes need both caps, so more is drawn; use it to compare or to
    /// find faults.
    DepthFail,
}

/// How far shadow volumes reach. In orthographic views all volumes are finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Extent {
    /// Ends volumes just beyond the visible receivers within the light's range, which fills fewer pixels. The
    /// volume is infinite if the light is directional or within the caster's bounds.
    #[default]
    Finite,
    /// Extends all volumes to infinity. This saves a test of each caster on the CPU and usually draws more
    /// pixels.
    Infinite,
}
