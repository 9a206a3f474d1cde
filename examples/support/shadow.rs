//! Techniques as a shot file names them.

use antumbra::insides::MAX_SPLIT;
use antumbra::insides::MapRequest;
use antumbra::prelude::*;
use antumbra::techniques::penumbra_wedge::{Overlap, VisibilityBuffer, WedgeSilhouette};
use antumbra::techniques::stencil_volume::{Counting, Extent};
use bevy_ecs::prelude::*;
use serde::Deserialize;

use super::shadow_map::ShotMap;

/// A technique and its settings.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(tag = "technique", rename_all = "snake_case", deny_unknown_fields)]
pub enum ShotShadow {
    /// Unshadowed.
    None {},
    /// [`StencilVolume`].
    StencilVolume {
        /// `auto` or `depth_fail`.
        #[serde(default)]
        counting: ShotCounting,
        /// `finite` or `infinite`.
        #[serde(default)]
        extent: ShotExtent,
    },
    /// [`PenumbraWedge`].
    PenumbraWedge {
        /// Parts along width and height.
        #[serde(default = "whole")]
        split: [u32; 2],
        /// `receiver` or `center`.
        #[serde(default)]
        silhouette: ShotSilhouette,
        /// `sampled`, `additive` or `paper`.
        #[serde(default)]
        overlap: ShotOverlap,
        /// `float`, `half` or `split8`.
        #[serde(default)]
        buffer: ShotBuffer,
    },
    /// [`ShadowMap`].
    ShadowMap(ShotMap),
    /// [`OmniMap`].
    OmniMap(ShotMap),
}

fn whole() -> [u32; 2] {
    [1, 1]
}

/// See [`WedgeSilhouette`].
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShotSilhouette {
    #[default]
    Receiver,
    Center,
}

/// See [`Overlap`].
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShotOverlap {
    #[default]
    Sampled,
    Additive,
    Paper,
}

/// See [`VisibilityBuffer`].
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShotBuffer {
    #[default]
    Float,
    Half,
    Split8,
}

/// See [`Counting`].
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShotCounting {
    #[default]
    Auto,
    DepthFail,
}

/// See [`Extent`].
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShotExtent {
    #[default]
    Finite,
    Infinite,
}

impl ShotShadow {
    /// Checks the settings for a light.
    ///
    /// # Errors
    /// What is wrong, after the name of the setting.
    pub fn check(self, light: &Light) -> Result<(), String> {
        let checked = match self {
            Self::ShadowMap(map) => MapRequest::of_shadow_map(&map.shadow_map()?, light),
            Self::OmniMap(map) => MapRequest::of_omni_map(&map.omni_map()?, light),
            Self::PenumbraWedge { split, .. } if split.iter().any(|n| !(1..=MAX_SPLIT).contains(n)) => {
                return Err(format!(
                    "shadow.split: {split:?} must be two numbers of 1..={MAX_SPLIT}"
                ));
            }
            Self::None {} | Self::StencilVolume { .. } | Self::PenumbraWedge { .. } => return Ok(()),
        };
        checked.map(drop).map_err(|error| format!("shadow: {error}"))
    }

    /// Gives the light the technique's component; none for an unshadowed light.
    pub fn insert(self, light: &mut EntityWorldMut) {
        match self {
            Self::None {} => {}
            // What is wrong with a map was found before.
            Self::ShadowMap(map) => {
                if let Ok(map) = map.shadow_map() {
                    light.insert(map);
                }
            }
            Self::OmniMap(map) => {
                if let Ok(map) = map.omni_map() {
                    light.insert(map);
                }
            }
            Self::StencilVolume { counting, extent } => {
                light.insert(StencilVolume {
                    counting: match counting {
                        ShotCounting::Auto => Counting::Auto,
                        ShotCounting::DepthFail => Counting::DepthFail,
                    },
                    extent: match extent {
                        ShotExtent::Finite => Extent::Finite,
                        ShotExtent::Infinite => Extent::Infinite,
                    },
                });
            }
            Self::PenumbraWedge {
                split,
                silhouette,
                overlap,
                buffer,
            } => {
                light.insert(PenumbraWedge {
                    split,
                    silhouette: match silhouette {
                        ShotSilhouette::Receiver => WedgeSilhouette::Receiver,
                        ShotSilhouette::Center => WedgeSilhouette::Center,
                    },
                    overlap: match overlap {
                        ShotOverlap::Sampled => Overlap::Sampled,
                        ShotOverlap::Additive => Overlap::Additive,
                        ShotOverlap::Paper => Overlap::Paper,
                    },
                    buffer: match buffer {
                        ShotBuffer::Float => VisibilityBuffer::Float,
                        ShotBuffer::Half => VisibilityBuffer::Half,
                        ShotBuffer::Split8 => VisibilityBuffer::Split8,
                    },
                    ..Default::default()
                });
            }
        }
    }
}
