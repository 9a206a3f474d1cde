//! Reasons why a light's map is poorer than asked for.

use bevy_ecs::prelude::Entity;

/// The reason why a light's map is poorer than asked for, though memory is not short.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// The map is larger than [`MapSettings::largest`](super::settings::MapSettings::largest) or than the device allows. It has the largest size
    /// that is allowed.
    #[error("resolution {wanted} is beyond the limit of {limit} texels; it is {limit} now")]
    Largest {
        /// Resolution that was asked for, texels.
        wanted: u32,
        /// Largest resolution, texels.
        limit: u32,
    },
    /// The shadow is much coarser than the picture.
    #[error("near the camera a texel of the map covers {pixels} pixels along a side")]
    Coarse {
        /// Number of pixels along a side that a texel covers where the nearest receivers are.
        pixels: u32,
    },
    /// The steps of the map's format are too long for what the light shines on.
    #[error("its format tells hardly any distances apart within {centimetres} cm of the light")]
    Steps {
        /// Distance from the light, centimetres, within which steps are about as long as the distance.
        centimetres: u32,
    },
}

/// A problem with a light's map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapReport {
    /// The light.
    pub entity: Entity,
    /// The problem.
    pub error: MapError,
}
