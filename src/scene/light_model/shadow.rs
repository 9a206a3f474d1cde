//! The look of a light's shadows: their colour, their place, their softness.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;
use glam::Vec3;

/// Colour and darkness of a light's shadows. Default: black and wholly dark.
///
/// In a shadow, the diffuse light is a blend of the light's colour and the shadow's colour, weighted by visibility, so it keeps
/// its gradients. Highlights do not take the shadow's colour: they are scaled by visibility alone.
///
/// Surfaces in shadow receive the shadow's colour, so those that the light does not see are drawn too, and occlusion from the
/// light saves nothing.
/// Source: Pellacini & Vidimce 2004, GPU Gems ch. 10, §10.2.4.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
pub struct ShadowTint {
    /// Colour of the shadow, linear RGB, each component at least 0. Like the light's own colour it is multiplied by
    /// the light's intensity. Default: black.
    pub color: Vec3,
    /// Share of the light that casters take away, 0 to 1. Lower values let light pass through casters; at 0 there
    /// is no shadow but on highlights. Default: 1.
    pub darkness: f32,
}

impl Default for ShadowTint {
    fn default() -> Self {
        Self {
            color: Vec3::ZERO,
            darkness: 1.0,
        }
    }
}

/// The place from which a light's shadows are cast, in world space, if it is not the light's own place. The light
/// still shines from its own place. So a highlight can stay in the eyes of a character while the shadow moves off
/// the face.
///
/// Shadows of baked maps stay where they were baked, which is reported.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Debug, Clone, PartialEq)
)]
pub enum ShadowOrigin {
    /// Shadows are cast from this point, metres. It moves shadows of all lights but directional ones.
    Position(Vec3),
    /// Shadows fall in this direction, which need not be a unit vector. It moves shadows of directional lights.
    Direction(Vec3),
}

/// The extent that a light's shadows are cast with, if it is not the light's own: the radius in metres of a sphere
/// around the light, at least 0. Higher values give wider penumbras and cost more. The light shines as before.
///
/// Penumbra wedges take it as the extent of the light: point, spot and sphere lights cast as spheres of this
/// radius, and rectangles keep their proportions and get this radius around them. Smoothies take it as the radius of
/// the light from which their width follows; for a directional light it is the width, and their spread grows with it. Maps, perspective ones too,
/// take it as the softness of their filter ([`MapFilter`](crate::techniques::maps::MapFilter)): a share of the distance
/// from the light, or metres for a directional light. Occlusion textures take it as the extent of the light as wedges do, and
/// ignore it for directional lights, which have an angle there
/// ([`OcclusionTexture::angle_deg`](crate::techniques::OcclusionTexture::angle_deg)). Stencil volumes are always hard and
/// ignore it, baked maps have the width of their window of time and ignore it, and wedges ignore it for directional lights,
/// which have no extent in metres.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Debug, Clone, PartialEq)
)]
pub struct ShadowSoftness(pub f32);
