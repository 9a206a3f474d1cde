//! Settings of a light's map, and settings of all maps together.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

/// The filter that combines the comparisons of a pixel with the map into visibility. Each tap compares with
/// up to four texels. Default: [`MapFilter::Bilinear`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum MapFilter {
    /// One tap: the four nearest texels, weighted by the position between them, in hardware where the format
    /// allows. It is the fastest; edges are about a texel wide.
    #[default]
    Bilinear,
    /// The mean of 16 bilinear taps over 4×4 texels, for smoother edges. Source: Bunnell & Pellacini 2004,
    /// GPU Gems ch. 11, §11.3.
    #[cfg_attr(feature = "serde", serde(rename = "brute_4x4"))]
    Brute4x4,
    /// Four of the 16 taps of [`MapFilter::Brute4x4`], which depend on the pixel. It costs a quarter and
    /// leaves a fine pattern at edges. Source: Bunnell & Pellacini 2004, GPU Gems ch. 11, §11.4.
    #[cfg_attr(feature = "serde", serde(rename = "dithered_4"))]
    Dithered4,
    /// 64 taps jittered over a disc, for wide soft edges. Source: Uralsky & Ahmad 2004, "Soft Shadows"
    /// (NVIDIA SDK white paper).
    Jittered {
        /// Radius of the disc, at least 0: for point and spot lights a share of the distance from the light,
        /// for directional lights metres. Higher values blur edges more and show more noise.
        #[cfg_attr(feature = "schema", schemars(range(min = 0), example = 0.01))]
        softness: f32,
        /// Looks up the eight taps of the rim first, and the others only where those disagree. Measured, it
        /// takes 7 times fewer taps. A caster that is inside the disc without touching its rim may be missed. Files may
        /// leave it out for true.
        #[cfg_attr(feature = "serde", serde(default = "is_adaptive"))]
        adaptive: bool,
    },
    /// Four taps on a circle around the point, for a light blur. Source: Gerasimov 2004, GPU Gems ch. 12,
    /// listing 12-3.
    #[cfg_attr(feature = "serde", serde(rename = "soft_4"))]
    Soft4 {
        /// Radius of the circle, at least 0: for point and spot lights a share of the distance from the
        /// light, for directional lights metres. Higher values blur edges more, until four separate edges
        /// show.
        #[cfg_attr(feature = "schema", schemars(range(min = 0), example = 0.01))]
        softness: f32,
    },
}

/// The jittered filter's `adaptive`, if a file says nothing of it.
#[cfg(feature = "serde")]
fn is_adaptive() -> bool {
    true
}

impl MapFilter {
    /// Returns the largest number of taps at a pixel.
    pub fn most_taps(self) -> u32 {
        match self {
            Self::Bilinear => 1,
            Self::Brute4x4 => 16,
            Self::Dithered4 | Self::Soft4 { .. } => 4,
            Self::Jittered { .. } => 64,
        }
    }

    /// Returns the filter with another softness. A filter that has none becomes a jittered one, unless the softness
    /// is 0.
    pub fn softened(self, softness: f32) -> Self {
        match self {
            Self::Jittered { adaptive, .. } => Self::Jittered { softness, adaptive },
            Self::Soft4 { .. } => Self::Soft4 { softness },
            other if softness == 0.0 => other,
            Self::Bilinear | Self::Brute4x4 | Self::Dithered4 => Self::Jittered {
                softness,
                adaptive: true,
            },
        }
    }

    /// Returns the softness, if the filter has one.
    pub fn softness(self) -> Option<f32> {
        match self {
            Self::Jittered { softness, .. } | Self::Soft4 { softness } => Some(softness),
            Self::Bilinear | Self::Brute4x4 | Self::Dithered4 => None,
        }
    }
}

/// The format of a texel of an omnidirectional map. Formats other than depth take a conversion pass, a second
/// texture, and comparisons in the shader. Default: [`MapFormat::Depth`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum MapFormat {
    /// The texel holds depth, which hardware compares. This is the fastest format.
    #[default]
    Depth,
    /// The texel holds the squared distance as a 32-bit float. Source: Gerasimov 2004, GPU Gems ch. 12,
    /// §12.2.3.
    R32Float,
    /// The texel holds the squared distance in two of four bytes, by the cheaper method of Gerasimov 2004,
    /// §12.3. The steps are 1/65280 of the squared range: distances below 1/255 of the range look alike. Without a
    /// range, that of the farthest caster counts; a lamp over an open field then shows no shadows near it, which is
    /// reported.
    Rgba8TwoBytes,
    /// The texel holds the squared distance in four bytes, by the other method of Gerasimov 2004, §12.3. It is
    /// about as exact as a float farther from the light than 1/200 of the range or, without a range, of the distance
    /// of the farthest caster.
    Rgba8FourBytes,
}

/// The surface of the casters that the map holds. A surface other than the nearest draws the casters of a
/// face twice, and takes a conversion pass and a second texture. Default: [`MapSurface::Nearest`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum MapSurface {
    /// The map holds the surface nearest to the light. This is the fastest choice, and right for any caster.
    #[default]
    Nearest,
    /// The map holds the second surface, or the nearest where there is only one. This is for closed casters: a
    /// single sheet, such as a leaf or a banner, casts no shadow on the first surface behind it. Source: Wang &
    /// Molnar 1994, "Second-Depth Shadow Mapping".
    Second,
    /// The map holds the middle between the nearest and the second surface. Source: Woo 1992, "The Shadow
    /// Depth Map Revisited".
    Midpoint,
}

/// The bias that keeps a surface from shadowing itself. Default: [`MapBias::Auto`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "Option<ManualBias>", into = "Option<ManualBias>")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum MapBias {
    /// The bias is derived from the map's texel and the surface; there is nothing to set.
    #[default]
    Auto,
    /// Fixed values replace the share of a texel by which `Auto` raises the receiver's plane. Higher values
    /// remove false shadows on lit surfaces, but separate shadows from their casters.
    Manual {
        /// Offset along the surface's normal, texels; at least 0.
        normal_texels: f32,
        /// Offset towards the light, metres; at least 0.
        depth_metres: f32,
        /// Offset towards the light, as a share of the distance from it; at least 0, less than 1. Directional
        /// lights ignore it, because they are at no distance. Source: Gerasimov 2004, GPU Gems ch. 12, whose
        /// bias multiplies.
        distance_share: f32,
    },
}

/// A bias with fixed values, as a file holds it. `null`, or a file without a bias, gives [`MapBias::Auto`].
#[cfg(feature = "serde")]
#[derive(Default, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(extend("x-rust" = "MapBias::Manual")))]
struct ManualBias {
    /// Offset along the surface's normal, texels; at least 0. Default: 0.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    normal_texels: f32,
    /// Offset towards the light, metres; at least 0. Default: 0.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    depth_metres: f32,
    /// Offset towards the light, as a share of the distance from it; at least 0, less than 1. Directional lights
    /// ignore it. Default: 0.
    #[cfg_attr(feature = "schema", schemars(range(min = 0, max = 1)))]
    distance_share: f32,
}

#[cfg(feature = "serde")]
impl From<Option<ManualBias>> for MapBias {
    fn from(bias: Option<ManualBias>) -> Self {
        bias.map_or(Self::Auto, |bias| Self::Manual {
            normal_texels: bias.normal_texels,
            depth_metres: bias.depth_metres,
            distance_share: bias.distance_share,
        })
    }
}

#[cfg(feature = "serde")]
impl From<MapBias> for Option<ManualBias> {
    fn from(bias: MapBias) -> Self {
        match bias {
            MapBias::Auto => None,
            MapBias::Manual {
                normal_texels,
                depth_metres,
                distance_share,
            } => Some(ManualBias {
                normal_texels,
                depth_metres,
                distance_share,
            }),
        }
    }
}

/// Number of texels along a side of a map. Higher values sharpen edges; each doubling takes four times the
/// memory and fill rate. Default: automatic, 128 to 1024.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(
        untagged,
        expecting = "expected texels along a side, or {\"least\": 128, \"most\": 1024}"
    )
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum MapResolution {
    /// A fixed number of texels, greater than 0. [`MapSettings::largest`] limits it, and so does a shortage
    /// of memory, down to 64.
    #[cfg_attr(feature = "schema", schemars(extend("x-rust" = "MapResolution::Fixed(_)")))]
    Fixed(#[cfg_attr(feature = "schema", schemars(range(min = 1), example = 1024))] u32),
    /// A power of two with which a texel is no larger than a pixel at three of four points of the visible receivers; cascades
    /// take `most`, and perspective maps the longer side of the light's part of the screen, or more where they fit badly.
    #[cfg_attr(feature = "schema", schemars(extend("x-rust" = "MapResolution::Auto")))]
    Auto {
        /// Smallest number of texels, greater than 0. A shortage of memory does not go below it.
        #[cfg_attr(feature = "schema", schemars(range(min = 1), example = 128))]
        least: u32,
        /// Largest number of texels, at least `least`.
        #[cfg_attr(feature = "schema", schemars(range(min = 1), example = 1024))]
        most: u32,
    },
}

impl MapResolution {
    /// Returns the resolution with half as many texels along a side, at least 1.
    pub(crate) fn halved(self) -> Self {
        let half = |texels: u32| texels / 2 + u32::from(texels == 1);
        match self {
            Self::Fixed(texels) => Self::Fixed(half(texels)),
            Self::Auto { least, most } => Self::Auto {
                least: half(least),
                most: half(most),
            },
        }
    }
}

impl Default for MapResolution {
    fn default() -> Self {
        Self::Auto {
            least: 128,
            most: 1024,
        }
    }
}

/// The cascades of a directional light: its maps, which divide the view depth among them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Cascades {
    /// Number of maps, 1 to 4. More give finer texels near the camera; each takes the memory and the draws of
    /// one map. Default: 4.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 4)))]
    pub count: u32,
    /// View depth in metres beyond which nothing is shadowed, greater than 0. Shadows fade out before it, over the share
    /// `blend` of it. Lower values give finer texels nearby. Default: infinite, which reaches as far as shadows are seen
    /// that are half a pixel long. In pictures of few pixels, a pixel counts as at most 1.8° wide.
    #[cfg_attr(feature = "schema", schemars(range(min = 0), example = 50.0))]
    pub distance: f32,
    /// Logarithmic share of the division of depth, 0 to 1. 0 makes equal parts of the view depth; 1 makes
    /// equal ratios, which gives near surfaces finer texels and far ones coarser. Where the farthest shadow is more than 256 times
    /// as far as the nearest receiver, the share grows towards 1. Default: 0.75. Source:
    /// Zhang et al. 2006, "Parallel-Split Shadow Maps".
    #[cfg_attr(feature = "schema", schemars(range(min = 0, max = 1)))]
    pub log_share: f32,
    /// Share of a cascade, at its border, in which it blends into the next; 0 to 0.5. Higher values hide the
    /// change of resolution better, but more pixels look up two maps. Where `distance` is set, it is also the share of it
    /// over which shadows fade out. Default: 0.1.
    #[cfg_attr(feature = "schema", schemars(range(min = 0, max = 0.5)))]
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

/// Limits of all maps together. The limit on their memory is [`TextureMemory::limit`](crate::techniques::TextureMemory::limit).
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct MapSettings {
    /// Number of faces of kept maps that are drawn again in a frame, those of the most visible lights first.
    /// The others show their last picture for another frame. Lower values bound the time of a frame; shadows
    /// of moving casters then lag. A face without a picture is drawn in any case. Default: 32.
    pub face_updates: u32,
    /// Number of frames without a move after which a caster counts as still. The still layer is drawn again
    /// whenever a caster starts or ceases to count as moving: higher values avoid that for casters that
    /// pause, lower values stop drawing resting casters every frame sooner. 0 counts as 1. Default: 8.
    pub still_after: u32,
    /// Longest side of a map, texels. The device's limit applies if it is less. Higher values allow sharper
    /// shadows, at up to four times the memory for each doubling. Default: 8192.
    pub largest: u32,
    /// Debug view: writes the number of taps of each pixel, divided by 64, into the mask's colours. Default:
    /// off.
    pub show_taps: bool,
}

impl Default for MapSettings {
    fn default() -> Self {
        Self {
            face_updates: 32,
            still_after: 8,
            largest: 8192,
            show_taps: false,
        }
    }
}
