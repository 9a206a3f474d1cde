//! What a user sets on a light.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

use crate::techniques::maps::{MapBias, MapFilter, MapFormat, MapResolution, MapSurface};

/// Gives a light at a place shadows by a map of all directions. Area lights cast from their centre. Alpha-tested casters
/// cast the holes of their texture; casters block from both sides.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
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
