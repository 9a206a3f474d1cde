//! What a user sets on a light.

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
use bevy_ecs::world::DeferredWorld;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

use crate::scene::ShadowedLight;
use crate::silhouettes::NeedsSilhouettes;

/// Gives a light hard shadows by stencil shadow volumes. Area lights cast from their centre.
///
/// Exact for any triangle mesh, open or closed; alpha-tested surfaces cast whole.
///
/// The stencil counts to 127. Of one caster at most 127 sheets may lie one behind the other; of a closed one 63, while the
/// light or the camera is within its bounds, since then fronts and backs count. Of casters there may be any number: from 127
/// on they are counted in rounds ([`MOST_STACKED`]), each of which costs a pass over the light's pixels that is next to
/// nothing. [`Silhouette::stacked`](crate::silhouettes::Silhouette::stacked) says how many sheets a caster has, by the boxes of
/// its pieces.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
#[require(NeedsSilhouettes, ShadowedLight)]
#[component(on_remove = light_up)]
pub struct StencilVolume {
    /// Which way intersections with the volumes are counted.
    pub counting: Counting,
    /// How far the volumes reach.
    pub extent: Extent,
}

/// Sheets that one round counts.
pub const MOST_STACKED: u32 = 127;

/// A light whose technique is taken away lights everything again.
fn light_up(mut world: DeferredWorld, context: HookContext) {
    world
        .commands()
        .entity(context.entity)
        .try_remove::<ShadowedLight>();
}

/// Which way intersections with a shadow volume are counted. The pictures are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
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
pub enum Extent {
    /// To just beyond what is seen of the receivers within the light's range, unless the light is within the caster's bounds
    /// or directional; then to infinity.
    #[default]
    Finite,
    /// To infinity.
    Infinite,
}
