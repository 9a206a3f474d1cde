//! The component that gives a light an omnidirectional map.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

use crate::scene::{Light, LightKind};
use crate::techniques::maps::request::{MapRequest, MapShape};
use crate::techniques::maps::{Cascades, MapBias, MapFilter, MapFormat, MapResolution, MapSurface};
use crate::techniques::registry::Refusal;

/// Gives a light at a position shadows by a map of all directions; a directional light is refused.
///
/// Area lights cast from their centre. Alpha-tested casters cast the holes of their texture. Casters block
/// from both sides.
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
pub struct OmniMap {
    /// Texels along a side of each of the six faces. Higher values sharpen edges; each doubling takes four
    /// times the memory and fill rate. Default: 128 to 1024, so that a texel is no larger than a
    /// pixel where receivers are seen.
    pub resolution: MapResolution,
    /// How comparisons with the map are combined: more taps soften or smooth edges and cost texture reads.
    /// Default: bilinear.
    pub filter: MapFilter,
    /// What a texel of the map holds. Default: depth, which is the fastest.
    pub format: MapFormat,
    /// Which surface of the casters the map holds. Default: the nearest.
    pub surface: MapSurface,
    /// How a surface is kept from shadowing itself. The default needs no setting.
    pub bias: MapBias,
    /// Distance from the light, metres, within which nothing casts; at least 1e-9 and less than the range.
    /// Raise it to ignore casters close to the light, such as a lamp's shade. Default (`None`): the light's
    /// clearance where it may be on a surface, else at most a hundred-thousandth of the range, and less as far
    /// as a caster is nearer. Depth is reversed floating point, so a small value costs no precision.
    #[cfg_attr(feature = "schema", schemars(range(min = 0), example = 0.05))]
    pub near: Option<f32>,
    /// Keeps the map from frame to frame and draws only the faces that changed. This takes 24 bytes times the
    /// square of the resolution, twice that while some casters move. Without it, lights share one map, which
    /// is drawn again for each of them every frame (§12.2.4); that suits lights whose casters all move.
    /// Default: true.
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
            let instead =
                "it needs a light with a position; use ShadowMap (`shadow_map`) for a directional light";
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
            beside: None,
            apart: false,
            pictures: false,
            layers: 0,
        };
        request.validated(light)
    }
}
