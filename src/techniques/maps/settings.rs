//! What a user sets on a light with a map, and for all maps together.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

/// How the comparisons of a pixel with the map are put together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub enum MapFilter {
    /// The four nearest texels, weighted by the position between them: one tap, in hardware where the format allows.
    #[default]
    Bilinear,
    /// The mean of 16 such taps over 4×4 texels. Source: Bunnell & Pellacini 2004, GPU Gems ch. 11, §11.3.
    Brute4x4,
    /// Four of the 16, which ones by the pixel. Source: the same, §11.4.
    Dithered4,
    /// 64 taps jittered over a disc. Source: Uralsky & Ahmad 2004, "Soft Shadows" (NVIDIA SDK white paper).
    Jittered {
        /// Radius of the disc: for point and spot lights a share of the distance from the light, for directional lights
        /// metres; ≥ 0.
        softness: f32,
        /// Looks at the eight taps of the rim first, and at the others only where those disagree.
        adaptive: bool,
    },
    /// Four taps around the point. Source: Gerasimov 2004, GPU Gems ch. 12, listing 12-3.
    Soft4 {
        /// How far off they are, as for [`MapFilter::Jittered`].
        softness: f32,
    },
}

impl MapFilter {
    /// Taps of a pixel at most.
    pub fn most_taps(self) -> u32 {
        match self {
            Self::Bilinear => 1,
            Self::Brute4x4 => 16,
            Self::Dithered4 | Self::Soft4 { .. } => 4,
            Self::Jittered { .. } => 64,
        }
    }

    /// The softness, if the filter has one.
    pub fn softness(self) -> Option<f32> {
        match self {
            Self::Jittered { softness, .. } | Self::Soft4 { softness } => Some(softness),
            Self::Bilinear | Self::Brute4x4 | Self::Dithered4 => None,
        }
    }
}

/// What a texel of an omnidirectional map holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum MapFormat {
    /// Depth, compared in hardware.
    #[default]
    Depth,
    /// Squared distance, as a float. Source: Gerasimov 2004, GPU Gems ch. 12, §12.2.3.
    R32Float,
    /// Squared distance in two bytes of four, the cheaper method of §12.3: in steps of 1/65280 of the range's square
    /// ([`packing::TWO_BYTES_STEP`](super::packing::TWO_BYTES_STEP)).
    Rgba8TwoBytes,
    /// Squared distance in four bytes, the other method of §12.3: as exact as a float.
    Rgba8FourBytes,
}

/// Which surface of the casters the map holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum MapSurface {
    /// The one nearest to the light.
    #[default]
    Nearest,
    /// The second, or the nearest where there is one alone. Source: Wang & Molnar 1994, "Second-Depth Shadow Mapping".
    Second,
    /// Halfway between the two. Source: Woo 1992, "The Shadow Depth Map Revisited".
    Midpoint,
}

/// What keeps a surface from shadowing itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub enum MapBias {
    /// What the map's texel and the surface ask for.
    #[default]
    Auto,
    /// In place of the share of a texel that `Auto` adds to the comparison with the receiver's plane.
    Manual {
        /// Along the surface's normal, texels; ≥ 0.
        normal_texels: f32,
        /// Towards the light, metres; ≥ 0.
        depth_metres: f32,
        /// Towards the light, as a share of the distance from it; 0..1. Not for directional lights, which are nowhere.
        /// Source: Gerasimov 2004, GPU Gems ch. 12, whose bias multiplies.
        distance_share: f32,
    },
}

/// Texels along a side of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub enum MapResolution {
    /// So many; > 0.
    Fixed(u32),
    /// A power of two that follows the light's size on the screen.
    Auto {
        /// At least; > 0.
        least: u32,
        /// At most; ≥ `least`.
        most: u32,
    },
}

impl Default for MapResolution {
    fn default() -> Self {
        Self::Auto {
            least: 128,
            most: 1024,
        }
    }
}

/// Limits of all maps together.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct MapSettings {
    /// Bytes of the maps that are kept. Beyond, the least visible lights lose resolution, then their cache.
    pub memory_limit: u64,
    /// Faces of kept maps that are drawn anew in a frame; those of the most visible lights first. The others keep what
    /// they show for a frame more. A face that shows nothing yet is drawn in any case.
    pub face_updates: u32,
    /// Frames without a move after which a caster counts as still.
    pub still_after: u32,
    /// Longest side of a map, texels; that of the device if it is less.
    pub largest: u32,
    /// Leaves the taps of each pixel, in parts of 64, in the mask's colours: a debug view.
    pub show_taps: bool,
}

impl Default for MapSettings {
    fn default() -> Self {
        Self {
            memory_limit: 256 << 20,
            face_updates: 32,
            still_after: 8,
            largest: 8192,
            show_taps: false,
        }
    }
}

/// Why a light with a map has no shadow, or not the one that was asked for.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// The component does not fit the kind of light.
    #[error("{component} does not fit a {light} light: {instead}")]
    Kind {
        /// Component.
        component: &'static str,
        /// Kind of light.
        light: &'static str,
        /// What the component needs, and what to use instead.
        instead: &'static str,
    },
    /// No texels.
    #[error("resolution is {0}, it must be greater than 0, and the least at most the most")]
    Resolution(u32),
    /// Not usable, or beyond what the light reaches.
    #[error("near is {near} m, it must be greater than 0 and less than the range, {range} m")]
    Near {
        /// Metres.
        near: f32,
        /// Metres.
        range: f32,
    },
    /// NaN, infinite or negative.
    #[error("softness is {0}, it must be finite and at least 0")]
    Softness(f32),
    /// NaN, infinite or negative.
    #[error("bias is {0}, it must be finite and at least 0")]
    Bias(f32),
    /// Out of range.
    #[error("{0} cascades, 1 to 4 are possible")]
    CascadeCount(u32),
    /// NaN or not positive, or a share beyond 1.
    #[error("{what} of the cascades is {value}")]
    Cascades {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f32,
    },
    /// The map is larger than [`MapSettings::largest`] or the device allows; it was made as large as that.
    #[error("resolution {wanted} is beyond the limit of {limit} texels; it is {limit} now")]
    Largest {
        /// Texels.
        wanted: u32,
        /// Texels.
        limit: u32,
    },
    /// Memory is short; the shadow is coarser.
    #[error("memory for maps is short: resolution {wanted} became {given}")]
    Coarser {
        /// Texels.
        wanted: u32,
        /// Texels.
        given: u32,
    },
    /// Memory is short; the map is drawn every frame.
    #[error("memory for maps is short: the map is not kept, and drawn every frame at resolution {given}")]
    Uncached {
        /// Texels.
        given: u32,
    },
}

impl MapError {
    /// Whether the light has no shadow at all.
    pub fn is_fatal(&self) -> bool {
        !matches!(
            self,
            Self::Largest { .. } | Self::Coarser { .. } | Self::Uncached { .. }
        )
    }
}
