//! Techniques as a shot file names them.

use antumbra::prelude::*;
use antumbra::techniques::stencil_volume::{Counting, Extent};
use bevy_ecs::prelude::*;
use serde::Deserialize;

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
    /// Gives the light the technique's component; none for an unshadowed light.
    pub fn insert(self, light: &mut EntityWorldMut) {
        match self {
            Self::None {} => {}
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
        }
    }
}
