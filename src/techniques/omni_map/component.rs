//! What a user sets on a light.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

use crate::scene::{Light, LightKind};
use crate::techniques::maps::request::{MapRequest, MapShape};
use crate::techniques::maps::{Cascades, MapBias, MapFilter, MapFormat, MapResolution, MapSurface};
use crate::techniques::registry::Refusal;

/// Gives a light at a place shadows by a map of all directions. Area lights cast from their centre. Alpha-tested casters
/// cast the holes of their texture; casters block from both sides.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
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
pub struct OmniMap {
    /// Texels along a side of each of the six faces.
    pub resolution: MapResolution,
    /// How comparisons are put together.
    pub filter: MapFilter,
    /// What a texel holds.
    pub format: MapFormat,
    /// Which surface of the casters the map holds.
    pub surface: MapSurface,
    /// What keeps a surface from shadowing itself.
    pub bias: MapBias,
    /// Distance from the light before which nothing casts, metres; `None`: a hundred-thousandth of its range.
    pub near: Option<f32>,
    /// Keeps the map and draws only what changed. Without it, all such lights share one map, which is drawn anew for each
    /// (§12.2.4).
    pub cached: bool,
}

impl Default for OmniMap {
    fn default() -> Self {
        Self {
            resolution: MapResolution::default(),
            filter: MapFilter::default(),
            format: MapFormat::default(),
            surface: MapSurface::default(),
            bias: MapBias::default(),
            near: None,
            cached: true,
        }
    }
}

impl OmniMap {
    /// What the component asks for.
    ///
    /// # Errors
    /// The first setting that cannot be drawn with.
    pub fn request(&self, light: &Light) -> Result<MapRequest, Refusal> {
        if light.kind == LightKind::Directional {
            let instead = "it needs a light with a position; use ShadowMap for a directional light";
            return Err(Refusal::kind(light, instead));
        }
        let request = MapRequest {
            shape: MapShape::Cube,
            resolution: self.resolution,
            filter: self.filter,
            format: self.format,
            surface: self.surface,
            bias: self.bias,
            near: self.near,
            cached: self.cached,
            cascades: Cascades::default(),
        };
        request.validated(light)
    }
}
