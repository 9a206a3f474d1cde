//! The component that gives a light a shadow map, and the settings of cascades.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

use crate::techniques::maps::{MapBias, MapFilter, MapResolution, MapSurface};

/// Gives a spot light or a directional light shadows by a shadow map.
///
/// Alpha-tested casters cast the holes of their texture. Casters block from both sides.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
pub struct ShadowMap {
    /// Texels along a side of the map, or of each cascade. Higher values sharpen edges; each doubling takes
    /// four times the memory and fill rate. Default: 128 to 1024, by the light's size on the screen; cascades
    /// take the upper limit.
    pub resolution: MapResolution,
    /// How comparisons with the map are combined: more taps soften or smooth edges and cost texture reads.
    /// Default: bilinear.
    pub filter: MapFilter,
    /// Which surface of the casters the map holds. Default: the nearest.
    pub surface: MapSurface,
    /// How a surface is kept from shadowing itself. The default needs no setting.
    pub bias: MapBias,
    /// Distance from a spot light, metres, within which nothing casts; greater than 0 and less than the
    /// range. Raise it to ignore casters close to the light, such as a lamp's shade. Default (`None`): a
    /// hundred-thousandth of the range. Depth is reversed floating point, so a small value costs no
    /// precision.
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

/// How a directional light's maps share the view depth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub struct Cascades {
    /// Number of maps, 1 to 4. More give finer texels near the camera; each takes the memory and the draws of
    /// one map. Default: 4.
    pub count: u32,
    /// View depth in metres beyond which nothing is shadowed, greater than 0. Lower values give finer texels
    /// nearby. Default: infinite, which reaches as far as surfaces are seen.
    pub distance: f32,
    /// How depth is divided, 0 to 1. 0 makes equal parts of the view depth; 1 makes equal ratios, which gives
    /// near surfaces finer texels and far ones coarser. Default: 0.75. Source: Zhang et al. 2006,
    /// "Parallel-Split Shadow Maps".
    pub log_share: f32,
    /// Share of a cascade, at its border, in which it blends into the next; 0 to 0.5. Higher values hide the
    /// change of resolution better, but more pixels look up two maps. Default: 0.1.
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
