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

/// Gives a spot light or a directional light shadows by a map. Alpha-tested casters cast the holes of their texture;
/// casters block from both sides.
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
pub struct ShadowMap {
    /// Texels along a side, of each cascade.
    pub resolution: MapResolution,
    /// How comparisons are put together.
    pub filter: MapFilter,
    /// Which surface of the casters the map holds.
    pub surface: MapSurface,
    /// What keeps a surface from shadowing itself.
    pub bias: MapBias,
    /// Distance from a spot light before which nothing casts, metres; `None`: a hundred-thousandth of its range.
    pub near: Option<f32>,
    /// Keeps the map and draws only what changed.
    pub cached: bool,
    /// Of a directional light.
    pub cascades: Cascades,
}

impl Default for ShadowMap {
    fn default() -> Self {
        Self {
            resolution: MapResolution::default(),
            filter: MapFilter::default(),
            surface: MapSurface::default(),
            bias: MapBias::default(),
            near: None,
            cached: true,
            cascades: Cascades::default(),
        }
    }
}

/// Half-angle beyond which a spot light's map has the faces of a cube, radians: there a face spends most of its texels
/// near its rim.
const WIDEST_SPOT: f32 = 1.05;

impl ShadowMap {
    /// What the component asks for.
    ///
    /// # Errors
    /// The first setting that cannot be drawn with.
    pub fn request(&self, light: &Light) -> Result<MapRequest, Refusal> {
        let shape = match light.kind {
            LightKind::Directional => MapShape::Cascades,
            LightKind::Spot { outer_angle, .. } if outer_angle > WIDEST_SPOT => MapShape::Cube,
            LightKind::Spot { .. } => MapShape::Spot,
            LightKind::Point | LightKind::Rect { .. } | LightKind::Sphere { .. } => {
                let instead = "it needs a spot or directional light; use OmniMap for a light with a position";
                return Err(Refusal::kind(light, instead));
            }
        };
        let request = MapRequest {
            shape,
            resolution: self.resolution,
            filter: self.filter,
            format: MapFormat::Depth,
            surface: self.surface,
            bias: self.bias,
            near: self.near,
            cached: self.cached,
            cascades: self.cascades,
        };
        request.validated(light)
    }
}
