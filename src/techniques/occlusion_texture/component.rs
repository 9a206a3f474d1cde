//! The component that gives a light soft shadows by occlusion textures.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

use crate::scene::{Light, LightKind};
use crate::techniques::registry::Refusal;

/// Most slices of a light: four channels of four colour targets, which every WebGPU device can draw at once.
pub const MOST_SLICES: u32 = 16;

/// Smallest and largest resolution, texels along a side.
const RESOLUTIONS: std::ops::RangeInclusive<u32> = 16..=4096;

/// Gives a rectangle, sphere or directional light soft shadows whose cost does not depend on the size of the light.
///
/// The casters are cut into slices parallel to the light. A picture of each slice is filtered once, and a pixel looks up
/// filtered values of each slice between itself and the light. Shadows are smooth and plausible, not exact: what a pixel
/// sees of a slice casts from its mean depth, and shadows begin a part of a slice behind their caster. Alpha-tested
/// casters cast the holes of their texture. Casters block from both sides.
/// An [`EmitterTexture`](crate::techniques::penumbra_wedge::EmitterTexture) is ignored: shadows are those of a light of
/// one colour.
///
/// All casters within reach of the light share the texels, so give the light a range.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OcclusionTexture {
    /// Number of slices, 1 to 16. Multiples of four use memory fully. Higher values bring shadows closer to their casters
    /// and let objects shadow themselves; each slice costs lookups at every pixel. Default: 8.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 16)))]
    pub slices: u32,
    /// How much thinner slices are away from the light than near it, 0 to 1: 0 makes all slices equally thick, 1 makes the
    /// farthest slice thinnest, by a factor of about twice the number of slices. Higher values help where casters stand on
    /// a ground that faces the light. Default: 0.
    #[cfg_attr(feature = "schema", schemars(range(min = 0, max = 1)))]
    pub weight: f32,
    /// Texels along a side of the pictures; a power of two, 16 to 4096. Higher values keep finer casters; each doubling
    /// takes somewhat more than four times the memory and filter time. Default: 256.
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = [16, 32, 64, 128, 256, 512, 1024, 2048, 4096]))
    )]
    pub resolution: u32,
    /// How means over rectangles of the pictures are prepared.
    pub filter: SliceFilter,
    /// How the shadows of the slices are combined.
    pub combine: SliceCombination,
    /// Mask of the selection layers whose casters also fill the picture of the next slice. It closes gaps where a thin
    /// caster passes from slice to slice, and darkens the penumbra of these casters. In files `true` stands for all layers
    /// and `false` for none. Default: 0, no layers.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "layers_in_file"))]
    #[cfg_attr(feature = "schema", schemars(with = "LayersInFile"))]
    pub close_leaks: u32,
    /// Angle that a directional light covers in the sky, degrees, from 0 to less than 180. Higher values soften shadows.
    /// Other lights do not use it. The softness of a light (`ShadowSoftness`) does not change it. Default: 0.53, the sun.
    #[cfg_attr(feature = "schema", schemars(range(min = 0, max = 180)))]
    pub angle_deg: f32,
}

/// How means over rectangles of a slice's picture are prepared and looked up.
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
pub enum SliceFilter {
    /// Level `l` holds means over squares of 2^l × 2^l texels. Up to level 3 such a square begins at each texel; above, squares
    /// begin an eighth of their side apart. A lookup blends two levels. Smooth and still while casters move; takes 19 bytes for
    /// each texel and four slices, and 89 with [`SliceCombination::Overlap`]. This is the default.
    #[default]
    NBuffers,
    /// Level `l` holds the mean over each aligned block of 2^l × 2^l texels. Takes the least memory. Shadows are blurred
    /// further than they should be, and shimmer as casters move. Devices with anisotropic filters keep the shape of long
    /// lights; others blur them equally in both directions.
    Mipmaps,
    /// Each texel holds the sum over all texels above and to the left of it, in 32 bits. The mean over any rectangle is exact.
    /// Takes 40 bytes for each texel and four slices, 88 with [`SliceCombination::Overlap`], and 16 loads in each lookup.
    SummedAreas,
}

/// How the shadows of a light's slices are combined.
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
pub enum SliceCombination {
    /// Multiplies the visibilities of the slices, as if each hid a random part of the light. It is the paper's way, and the
    /// cheapest that looks right where many objects overlap. A surface that passes through several slices is too light.
    Product,
    /// Takes the darkest slice. Shadows of several objects are too light.
    Maximum,
    /// Adds the hidden shares, at most the whole light. Shadows of several objects are too dark; a single surface that passes
    /// through several slices is right.
    Sum,
    /// Measures how much of each slice's shadow lies behind casters of the slices before it, and counts only the rest. Parts of
    /// one surface add up, casters behind each other count once, and casters that have nothing to do with each other multiply.
    /// Depths of casters are measured too: shadows begin closer behind their caster than with the other combinations, which let
    /// casters cast from the middle of their slice, and they do not jump where a caster moves from slice to slice. Takes three
    /// times the memory, somewhat more than three times the time to filter pictures, and up to six times the lookups where
    /// there are casters. This is the default, and the closest to the truth.
    #[default]
    Overlap,
}

/// Selection layers in a file.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(untagged, expecting = "expected true, false or a mask of layers")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
enum LayersInFile {
    /// All layers, or none.
    #[cfg_attr(
        feature = "schema",
        schemars(title = "all", extend("x-rust-true" = "u32::MAX", "x-rust-false" = "0"))
    )]
    All(bool),
    /// A mask of layers.
    #[cfg_attr(feature = "schema", schemars(title = "mask", extend("x-rust" = "_")))]
    Mask(u32),
}

/// Reads a mask of layers: a number, or whether it holds all layers.
#[cfg(feature = "serde")]
fn layers_in_file<'de, D: serde::Deserializer<'de>>(from: D) -> Result<u32, D::Error> {
    Ok(match <LayersInFile as serde::Deserialize>::deserialize(from)? {
        LayersInFile::All(true) => u32::MAX,
        LayersInFile::All(false) => 0,
        LayersInFile::Mask(mask) => mask,
    })
}

impl Default for OcclusionTexture {
    fn default() -> Self {
        Self {
            slices: 8,
            weight: 0.0,
            resolution: 256,
            filter: SliceFilter::default(),
            combine: SliceCombination::default(),
            close_leaks: 0,
            angle_deg: 0.53,
        }
    }
}

impl OcclusionTexture {
    /// Checks whether the light can be shadowed with these settings.
    pub(super) fn validated(&self, light: &Light) -> Result<(), Refusal> {
        if matches!(light.kind, LightKind::Point | LightKind::Spot { .. }) {
            let instead =
                "occlusion textures need a light with a size: use a sphere or a rectangle, or a map";
            return Err(Refusal::kind(light, instead));
        }
        let refuse = |setting, value, allowed| Err(Refusal::setting(setting, value, allowed));
        if !(1..=MOST_SLICES).contains(&self.slices) {
            return refuse("slices", self.slices as f32, "1 to 16 are possible");
        }
        if !(RESOLUTIONS.contains(&self.resolution) && self.resolution.is_power_of_two()) {
            let allowed = "it must be a power of two from 16 to 4096";
            return refuse("resolution", self.resolution as f32, allowed);
        }
        if !(0.0..=1.0).contains(&self.weight) {
            return refuse("weight", self.weight, "0 to 1 are possible");
        }
        if !(self.angle_deg >= 0.0 && self.angle_deg < 180.0) {
            return Err(Refusal::Setting {
                setting: "angle_deg",
                value: self.angle_deg,
                unit: "°",
                allowed: "it must be at least 0 and less than 180",
            });
        }
        Ok(())
    }

    /// Whether lookups need depths of casters, and what each slice and all slices before it cover together.
    pub(super) fn measures(&self) -> bool {
        self.combine == SliceCombination::Overlap
    }

    /// Number of colour targets, each of which holds four slices.
    pub fn groups(&self) -> u32 {
        self.slices.div_ceil(4)
    }
}
