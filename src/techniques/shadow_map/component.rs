//! The component that gives a light a shadow map, and the settings of cascades.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

use crate::scene::{Light, LightKind};
use crate::techniques::maps::request::{MapRequest, MapShape};
use crate::techniques::maps::{Cascades, MapBias, MapFilter, MapFormat, MapResolution, MapSurface};
use crate::techniques::registry::Refusal;

/// Gives a spot light or a directional light shadows by a shadow map.
///
/// Alpha-tested casters cast the holes of their texture. Casters block from both sides.
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
pub struct ShadowMap {
    /// Texels along a side of the map, or of each cascade. Higher values sharpen edges; each doubling takes
    /// four times the memory and fill rate. Default: 128 to 1024, so that a texel is no larger than
    /// a pixel where receivers are seen; cascades take the upper limit.
    pub resolution: MapResolution,
    /// How comparisons with the map are combined: more taps soften or smooth edges and cost texture reads.
    /// Default: bilinear.
    pub filter: MapFilter,
    /// Which surface of the casters the map holds. Default: the nearest.
    pub surface: MapSurface,
    /// How a surface is kept from shadowing itself. The default needs no setting.
    pub bias: MapBias,
    /// Distance from a spot light, metres, within which nothing casts; at least 1e-9 and less than the
    /// range. Raise it to ignore casters close to the light, such as a lamp's shade. Default (`None`): the light's
    /// clearance where it may be on a surface, else at most a hundred-thousandth of the range, and less as far
    /// as a caster is nearer. Depth is reversed floating point, so a small value costs no precision.
    #[cfg_attr(feature = "schema", schemars(range(min = 0), example = 0.05))]
    pub near: Option<f32>,
    /// Keeps the map from frame to frame and draws only the faces that changed. This takes 4 bytes a texel
    /// and face, twice that while some casters move. Without it, lights share a map that is drawn every
    /// frame; that suits lights whose casters all move. Default: true.
    pub cached: bool,
    /// How a directional light's maps share the view depth. Other lights ignore it.
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

impl ShadowMap {
    /// What the component asks for.
    ///
    /// # Errors
    /// The first setting that cannot be drawn with.
    pub fn request(&self, light: &Light) -> Result<MapRequest, Refusal> {
        if !matches!(light.kind, LightKind::Directional | LightKind::Spot { .. }) {
            let instead =
                "it needs a spot or directional light; use OmniMap (`omni_map`) for a light with a position";
            return Err(Refusal::kind(light, instead));
        }
        let request = MapRequest {
            shape: MapShape::of_light(light),
            resolution: self.resolution,
            filter: self.filter,
            format: MapFormat::Depth,
            surface: self.surface,
            bias: self.bias,
            near: self.near,
            cached: self.cached,
            cascades: self.cascades,
            beside: None,
            apart: false,
            pictures: false,
            layers: 0,
        };
        request.validated(light)
    }
}
