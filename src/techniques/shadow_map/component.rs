//! What a user sets on a light.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

use crate::techniques::maps::{MapBias, MapFilter, MapResolution, MapSurface};

/// Gives a spot light or a directional light shadows by a map. Alpha-tested casters cast the holes of their texture;
/// casters block from both sides.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
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

/// How a directional light's maps share the view.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub struct Cascades {
    /// 1 to 4.
    pub count: u32,
    /// View depth beyond which nothing is shadowed, metres; infinite: as far as surfaces are seen.
    pub distance: f32,
    /// 0: equal parts of the view depth; 1: equal ratios. Source: Zhang et al. 2006, "Parallel-Split Shadow Maps".
    pub log_share: f32,
    /// Share of a cascade, at its border, in which it passes into the next; 0 to 0.5.
    pub blend: f32,
}

impl Default for Cascades {
    fn default() -> Self {
        Self {
            count: 4,
            distance: f32::INFINITY,
            log_share: 0.75, // by eye, between the extremes of the source
            blend: 0.1,
        }
    }
}
