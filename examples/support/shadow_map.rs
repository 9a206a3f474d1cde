//! Maps as a shot file names them.

use antumbra::prelude::*;
use antumbra::techniques::maps::{MapBias, MapFilter, MapFormat, MapResolution, MapSurface};
use antumbra::techniques::shadow_map::Cascades;
use serde::Deserialize;

/// What both kinds of map have. Absent keys have the component's defaults.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShotMap {
    /// Texels along a side; absent: by the light's size on the screen.
    resolution: Option<u32>,
    /// `bilinear`, `brute_4x4`, `dithered_4`, `jittered`, `jittered_full` or `soft_4`.
    #[serde(default)]
    filter: ShotFilter,
    /// Of the last three filters.
    softness: Option<f32>,
    /// `nearest`, `second` or `midpoint`.
    #[serde(default)]
    surface: ShotSurface,
    /// Texels and metres; absent: by itself.
    bias: Option<ShotBias>,
    /// Metres.
    near: Option<f32>,
    /// The map is kept.
    cached: Option<bool>,
    /// Of an omnidirectional map: `depth`, `r32_float`, `rgba8_two_bytes` or `rgba8_four_bytes`.
    format: Option<ShotFormat>,
    /// Of a directional light.
    cascades: Option<ShotCascades>,
}

/// See [`Cascades`].
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShotCascades {
    count: Option<u32>,
    distance: Option<f32>,
    log_share: Option<f32>,
    blend: Option<f32>,
}

/// See [`MapBias::Manual`].
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShotBias {
    #[serde(default)]
    normal_texels: f32,
    #[serde(default)]
    depth_metres: f32,
    #[serde(default)]
    distance_share: f32,
}

/// See [`MapFilter`].
#[derive(Clone, Copy, Debug, Default, Deserialize)]
pub enum ShotFilter {
    #[default]
    #[serde(rename = "bilinear")]
    Bilinear,
    #[serde(rename = "brute_4x4")]
    Brute4x4,
    #[serde(rename = "dithered_4")]
    Dithered4,
    #[serde(rename = "jittered")]
    Jittered,
    #[serde(rename = "jittered_full")]
    JitteredFull,
    #[serde(rename = "soft_4")]
    Soft4,
}

/// See [`MapSurface`].
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShotSurface {
    #[default]
    Nearest,
    Second,
    Midpoint,
}

/// See [`MapFormat`].
#[derive(Clone, Copy, Debug, Deserialize)]
pub enum ShotFormat {
    #[serde(rename = "depth")]
    Depth,
    #[serde(rename = "r32_float")]
    R32Float,
    #[serde(rename = "rgba8_two_bytes")]
    Rgba8TwoBytes,
    #[serde(rename = "rgba8_four_bytes")]
    Rgba8FourBytes,
}

/// Softness of a filter that has one, unless the shot says another.
const SOFTNESS: f32 = 0.01;

impl ShotMap {
    fn resolution(&self) -> MapResolution {
        self.resolution
            .map_or_else(MapResolution::default, MapResolution::Fixed)
    }

    fn filter(&self) -> MapFilter {
        let softness = self.softness.unwrap_or(SOFTNESS);
        let jittered = |adaptive| MapFilter::Jittered { softness, adaptive };
        match self.filter {
            ShotFilter::Bilinear => MapFilter::Bilinear,
            ShotFilter::Brute4x4 => MapFilter::Brute4x4,
            ShotFilter::Dithered4 => MapFilter::Dithered4,
            ShotFilter::Jittered => jittered(true),
            ShotFilter::JitteredFull => jittered(false),
            ShotFilter::Soft4 => MapFilter::Soft4 { softness },
        }
    }

    fn surface(&self) -> MapSurface {
        match self.surface {
            ShotSurface::Nearest => MapSurface::Nearest,
            ShotSurface::Second => MapSurface::Second,
            ShotSurface::Midpoint => MapSurface::Midpoint,
        }
    }

    fn bias(&self) -> MapBias {
        self.bias.map_or(MapBias::Auto, |bias| MapBias::Manual {
            normal_texels: bias.normal_texels,
            depth_metres: bias.depth_metres,
            distance_share: bias.distance_share,
        })
    }

    /// The component of a spot or directional light.
    ///
    /// # Errors
    /// A key that such a map has not.
    pub fn shadow_map(&self) -> Result<ShadowMap, String> {
        if self.format.is_some() {
            return Err("shadow.format: a shadow_map has none, its texels are depths".to_owned());
        }
        let mut cascades = Cascades::default();
        if let Some(shot) = self.cascades {
            cascades = Cascades {
                count: shot.count.unwrap_or(cascades.count),
                distance: shot.distance.unwrap_or(cascades.distance),
                log_share: shot.log_share.unwrap_or(cascades.log_share),
                blend: shot.blend.unwrap_or(cascades.blend),
            };
        }
        Ok(ShadowMap {
            resolution: self.resolution(),
            filter: self.filter(),
            surface: self.surface(),
            bias: self.bias(),
            near: self.near,
            cached: self.cached.unwrap_or(true),
            cascades,
        })
    }

    /// The component of any light at a place.
    ///
    /// # Errors
    /// A key that such a map has not.
    pub fn omni_map(&self) -> Result<OmniMap, String> {
        if self.cascades.is_some() {
            return Err("shadow.cascades: an omni_map has none".to_owned());
        }
        let format = match self.format {
            None | Some(ShotFormat::Depth) => MapFormat::Depth,
            Some(ShotFormat::R32Float) => MapFormat::R32Float,
            Some(ShotFormat::Rgba8TwoBytes) => MapFormat::Rgba8TwoBytes,
            Some(ShotFormat::Rgba8FourBytes) => MapFormat::Rgba8FourBytes,
        };
        Ok(OmniMap {
            resolution: self.resolution(),
            filter: self.filter(),
            format,
            surface: self.surface(),
            bias: self.bias(),
            near: self.near,
            cached: self.cached.unwrap_or(true),
        })
    }
}
