//! Weights of ambient, diffuse and specular light.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;
use glam::Vec3;

/// Weights of what a light gives to a surface. Each is multiplied by the weight of the same name of the surface
/// ([`SurfaceWeights`]). Default: no ambient light, all of the diffuse and of the specular light.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
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
pub struct LightWeights {
    /// Weight of light that arrives from everywhere: that of a surface which faces the light, without shadows and
    /// on all sides of an object; at least 0. Default: 0.
    ///
    /// A light with ambient light also draws the surfaces that it does not see, so occlusion from the light saves
    /// nothing.
    pub ambient: f32,
    /// Weight of diffuse reflection; at least 0. Default: 1.
    pub diffuse: f32,
    /// Weight of highlights; at least 0. Default: 1.
    pub specular: f32,
}

impl Default for LightWeights {
    fn default() -> Self {
        Self {
            ambient: 0.0,
            diffuse: 1.0,
            specular: 1.0,
        }
    }
}

impl LightWeights {
    /// Returns ambient, diffuse and specular weight.
    pub fn to_vec3(self) -> Vec3 {
        Vec3::new(self.ambient, self.diffuse, self.specular)
    }
}

/// Weights of what an object shows of any light. Each is multiplied by the weight of the same name of the light
/// ([`LightWeights`]). Default: 1 each.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
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
pub struct SurfaceWeights {
    /// Weight of the ambient part of lights; at least 0. The ambient light of the view is not weighted. Default: 1.
    pub ambient: f32,
    /// Weight of diffuse reflection; at least 0. Default: 1.
    pub diffuse: f32,
    /// Weight of highlights; at least 0. Default: 1.
    pub specular: f32,
}

impl Default for SurfaceWeights {
    fn default() -> Self {
        Self {
            ambient: 1.0,
            diffuse: 1.0,
            specular: 1.0,
        }
    }
}

impl SurfaceWeights {
    /// Returns ambient, diffuse and specular weight. A weight that is NaN, negative or infinite counts as 1.
    pub fn to_vec3(self) -> Vec3 {
        let usable = |weight: f32| if is_weight(weight) { weight } else { 1.0 };
        Vec3::new(usable(self.ambient), usable(self.diffuse), usable(self.specular))
    }

    /// Returns whether all weights are finite and at least 0.
    pub fn is_valid(&self) -> bool {
        [self.ambient, self.diffuse, self.specular]
            .into_iter()
            .all(is_weight)
    }
}

/// Returns whether a weight is finite and at least 0.
pub fn is_weight(weight: f32) -> bool {
    weight.is_finite() && weight >= 0.0
}
