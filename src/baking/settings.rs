//! Settings, errors and results of a bake.

use std::path::PathBuf;

use bevy_ecs::prelude::*;

use super::unwrap::UnwrapNote;
use crate::scene::PathError;
use crate::techniques::occlusion_interval::MapsError;
use crate::techniques::occlusion_interval::component::DENSITIES;
use crate::techniques::occlusion_interval::maps::{IntervalMaps, MAX_BYTES, MAX_LAYERS, MAX_SIZE};

/// How maps are baked.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeSettings {
    /// Texels per metre of surfaces, 0.001 to 10000. Twice as many take four times the memory and time. Default: 8.
    pub texels_per_metre: f32,
    /// Most texels along each side of a page, 16 to 4096. Surfaces that need more are coarser. Default: 2048.
    pub page_size: u32,
    /// Layers of the objects that block the light, as in [`LightSelection`](crate::scene::LightSelection). Default: all.
    pub casts_for: u32,
    /// Objects that will move. They neither show nor cast shadows in the maps. Skinned and morphed ones need not be named.
    pub moving: Vec<Entity>,
}

impl BakeSettings {
    /// Checks that all numbers are usable.
    ///
    /// # Errors
    /// The first setting that is not.
    pub(super) fn check(&self) -> Result<(), BakeError> {
        let density = self.texels_per_metre;
        if !DENSITIES.contains(&density) {
            return Err(BakeError::Setting {
                setting: "texels_per_metre",
                value: density,
                allowed: "from 0.001 to 10000",
            });
        }
        if !(16..=MAX_SIZE).contains(&self.page_size) {
            return Err(BakeError::Setting {
                setting: "page_size",
                value: self.page_size as f32,
                allowed: "from 16 to 4096",
            });
        }
        Ok(())
    }
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            texels_per_metre: 8.0,
            page_size: 2048,
            casts_for: u32::MAX,
            moving: Vec::new(),
        }
    }
}

/// How far a bake is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BakeProgress {
    /// Texels that are done.
    pub done: u64,
    /// All texels.
    pub all: u64,
    /// Texels that an interrupted bake had done.
    pub resumed: u64,
}

/// Why maps cannot be baked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// The path of the light cannot be used.
    #[error("path: {0}")]
    Path(#[from] PathError),
    /// A setting cannot be used.
    #[error("{setting} is {value}, it must be {allowed}")]
    Setting {
        /// Name of the setting.
        setting: &'static str,
        /// Value of the setting.
        value: f32,
        /// Values that are allowed.
        allowed: &'static str,
    },
    /// Nothing in the scene stands still and shows shadows.
    #[error("nothing in the scene stands still and shows shadows")]
    Nothing,
    /// The maps would need more layers than a device holds, or more bytes than maps may have.
    #[error(
        "{texels} texels with up to {pairs} pairs of textures need more than {MAX_LAYERS} layers or {} GiB; use fewer texels per metre, or larger pages",
        MAX_BYTES >> 30
    )]
    TooLarge {
        /// Number of texels.
        texels: u64,
        /// Most pairs that a texel needs.
        pairs: usize,
    },
    /// The file of an interrupted bake cannot be read or written.
    #[error("{}: {error}", file.display())]
    Partial {
        /// The file.
        file: PathBuf,
        /// Message of the operating system.
        error: std::io::Error,
    },
    /// The maps cannot be written.
    #[error(transparent)]
    Maps(#[from] MapsError),
}

/// A point in which a bake differs from what was asked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BakeNote {
    /// The texture coordinates of a mesh are not used, or some of its triangles are left out.
    #[error("mesh \"{mesh}\": {note}")]
    Unwrap {
        /// Name of the mesh.
        mesh: String,
        /// What was wrong.
        note: UnwrapNote,
    },
    /// A chart is larger than a page.
    #[error(
        "mesh \"{mesh}\": a part has {texels_per_metre} texels per metre only, because a page is too small for more"
    )]
    Coarser {
        /// Name of the mesh.
        mesh: String,
        /// Density of the chart.
        texels_per_metre: f32,
    },
    /// No texel sees the light at any time: it never rises, its path lies inside of geometry, or texels are larger than surfaces.
    #[error(
        "nothing sees the light at any time: it never rises, its path lies inside of geometry, or texels are larger than surfaces"
    )]
    NeverSeen,
}

/// Baked maps, and notes about them.
#[derive(Clone, Debug, PartialEq)]
pub struct Bake {
    /// The maps.
    pub maps: IntervalMaps,
    /// Notes for the user: points in which the maps differ from what was asked for.
    pub notes: Vec<BakeNote>,
}
