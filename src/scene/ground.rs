//! Receivers on which shadows are blurred.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

/// Blurs the shadows of a [`PerspectiveMap`](crate::techniques::PerspectiveMap) on a receiver: a ground, a floor, a
/// wall. All other receivers keep the map's filter.
///
/// A blurred receiver shows no shadow that it casts on itself, so it should be about flat. Receivers in one plane with
/// one radius count as one, and a view has up to four. The width of the blur is measured in the plane of the two longer
/// sides of the receiver's bounds. Receivers beyond the fourth keep the map's filter, and a report names them. Other
/// techniques ignore this component.
///
/// Each light with a perspective map that lights such a receiver draws its map in every frame, and takes 8 more bytes
/// a texel.
///
/// Source: Kozlov 2004, GPU Gems ch. 14, §14.3.2.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
pub struct BlurredGround {
    /// Standard deviation of the Gaussian that blurs the shadows, metres; greater than 0. Two thirds of an edge's change
    /// lie within one radius to each side of it. Higher values blur more, and cost more texture reads, up to 41 a texel
    /// and direction. Default: 0.2.
    pub radius: f32,
}

impl Default for BlurredGround {
    fn default() -> Self {
        Self { radius: 0.2 }
    }
}
