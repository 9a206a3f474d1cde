//! The component that gives a light penumbra wedges.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

/// Gives a light soft shadows by penumbra wedges: noise-free, from geometry, without a shadow map.
///
/// Rectangles and spheres cast with their extent. Points, spots and directional lights, and areas of size 0,
/// cast exactly the hard shadow. Alpha-tested surfaces cast whole. Most lights need no setting but `split`,
/// where casters overlap much.
///
/// Source: Assarsson, Dougherty, Mounier & Akenine-Möller 2003, "An Optimized Soft Shadow Volume Algorithm
/// with Real-Time Performance"; potential silhouette edges: Laine, Aila, Assarsson, Lehtinen & Akenine-Möller
/// 2005, "Soft Shadow Volumes for Ray Tracing".
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
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
pub struct PenumbraWedge {
    /// Number of parts along a rectangle's width and height, each cast as a light of its own; 1 to 8. Default: 1, 1.
    ///
    /// Higher values separate overlapping casters better, and the time grows with the number of parts. Raise
    /// it for thin or tangled casters. A sphere is split into as many smaller spheres, which do not fill its
    /// disc evenly: split spheres only where much overlaps. Section 5.2.
    #[cfg_attr(feature = "schema", schemars(inner(range(min = 1, max = 8))))]
    pub split: [u32; 2],
    /// Which edges cast. Default: the silhouette as each receiver sees it.
    pub silhouette: WedgeSilhouette,
    /// How the coverage of several casters combines. Default: [`Overlap::Sampled`].
    pub overlap: Overlap,
    /// Format of the textures in which visibility is summed. Default: [`VisibilityBuffer::Float`].
    pub buffer: VisibilityBuffer,
    /// Volume that encloses the penumbra of an edge; a larger one takes longer. Default: tight.
    pub bounds: WedgeBounds,
    /// How the pixels are found at which coverage is computed; affects the time, not the picture. Default: by
    /// depth.
    pub culling: WedgeCulling,
    /// How areas are computed. Default: analytically.
    pub maths: CoverageMaths,
}

impl Default for PenumbraWedge {
    fn default() -> Self {
        Self {
            split: [1, 1],
            silhouette: WedgeSilhouette::default(),
            overlap: Overlap::default(),
            buffer: VisibilityBuffer::default(),
            bounds: WedgeBounds::default(),
            culling: WedgeCulling::default(),
            maths: CoverageMaths::default(),
        }
    }
}

/// The greatest number of casters one behind the other for which the samples of [`Overlap::Sampled`] are soft.
#[cfg(feature = "render")]
pub const MOST_IN_STEPS: u32 = 30;

/// The greatest number of casters that may lie one behind the other in a light with [`Overlap::Sampled`]. With more,
/// shadows may be too light, which is reported. [`LightSilhouettes::stacked`](crate::silhouettes::LightSilhouettes::stacked) is the number
/// that a light has.
pub const MOST_STACKED: u32 = 254;

/// Largest number of parts along a side of a light.
pub const MAX_SPLIT: u32 = 8;

impl PenumbraWedge {
    /// Returns the number of parts along width and height, each clamped to 1 to [`MAX_SPLIT`].
    pub fn parts(&self) -> [u32; 2] {
        self.split.map(|parts| parts.clamp(1, MAX_SPLIT))
    }

    /// Returns the silhouette that is cast. [`Overlap::Paper`] needs patches, which the silhouette from the
    /// centre alone has.
    pub fn used_silhouette(&self) -> WedgeSilhouette {
        match self.overlap {
            Overlap::Paper => WedgeSilhouette::Center,
            Overlap::Sampled | Overlap::Additive => self.silhouette,
        }
    }
}

/// Which edges cast.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
pub enum WedgeSilhouette {
    /// The silhouette as each receiver sees it. To the silhouette edges from the light's centre, it adds the
    /// edges of all triangles whose plane cuts the light. At each pixel, those edges count that bound what is
    /// in front of the light there.
    ///
    /// It is right for any caster by itself, and no facet jumps when the light moves. It takes up to about
    /// twice the time of [`WedgeSilhouette::Center`], most for dense meshes. After Laine et al. 2005.
    #[default]
    Receiver,
    /// The silhouette from the centre of the light, or of each of its parts. It draws fewer wedges, but
    /// shadows jump as facets turn away from the centre. [`Overlap::Paper`] always uses it.
    Center,
}

/// How the coverage of several casters combines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
pub enum Overlap {
    /// Estimates how much of the light is hidden from 21 soft samples on the light, corrected by the exact
    /// sum of coverages (a control variate). Takes one pass. Up to 254 casters may lie one behind the other
    /// ([`MOST_STACKED`]); from 31 on the samples are hard, so shadows jump a little when the light moves.
    ///
    /// The error is at most 0.03 where nothing overlaps. Where much overlaps, it is that of the samples
    /// and the sum. The samples are soft, so none jumps when the light moves. Where open meshes cast, there are nine
    /// samples on a device whose `max_color_attachment_bytes_per_sample` is less than 64. WebGPU guarantees 32.
    ///
    /// Needs a device that blends 32-bit floats, [`VisibilityBuffer::Float`] and a light without texture.
    /// Otherwise [`Overlap::Additive`] is used.
    #[default]
    Sampled,
    /// Coverages add up to at most 1. This is exact for casters that hide different parts of the light;
    /// overlapping ones darken too much. Takes one pass.
    Additive,
    /// Combines the coverage of one silhouette loop of all casters after the other, halfway between the
    /// extremes of no and full overlap: `c = max + ½ min`. Section 5.1, equation 1. For more than two loops it is half
    /// of the sum and half of the largest, so their order does not matter.
    ///
    /// A loop is summed first with its holes and the patch of triangles that they bound. Patches whose
    /// shadows cannot meet share a sum; beyond 16 sums, others share too. Takes a pass for each sum. Use it
    /// to compare with the paper.
    Paper,
}

/// Format of the textures in which visibility is summed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
pub enum VisibilityBuffer {
    /// A 32-bit float texture. [`VisibilityBuffer::Split8`] is used where the device cannot blend it.
    #[default]
    Float,
    /// A texture of half floats, which every device blends. It takes half the memory and about the same time.
    /// Rounding may let the order of casters show by 0.001. It cannot hold the counts of
    /// [`Overlap::Sampled`], so [`Overlap::Additive`] is used.
    Half,
    /// Twelve bits over the four bytes of two `Rgba8Unorm` textures, one for what is added and one for what
    /// is subtracted. It works on every device. Like [`VisibilityBuffer::Half`] it cannot hold counts, and
    /// many faces at a pixel may overflow ([`WedgeOverflow`](super::WedgeOverflow)). Section 4.3.
    Split8,
}

/// Volume that encloses the penumbra of an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
pub enum WedgeBounds {
    /// The convex hull of the penumbra of the light's own shape, which covers the fewest pixels.
    #[default]
    Tight,
    /// The tangent planes of the sphere around the light. They cover 1.3 to 2.9 times the pixels and take 1.0
    /// to 1.8 times as long; use them to compare.
    Sphere,
}

/// How the pixels are found at which the coverage of an edge is computed. The pictures are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
pub enum WedgeCulling {
    /// Pixels where a back face of the wedge is behind the surface. All wedges are one draw.
    #[default]
    Depth,
    /// Pixels where the surface is inside a half of the wedge, marked in the stencil first. It takes four
    /// draws an edge and 1.1 to 2.5 times as long. Section 4.4.
    Stencil,
    /// All pixels that the wedge covers. The other modes are measured against it.
    None,
}

/// How areas are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
pub enum CoverageMaths {
    /// Analytically, in the shader.
    #[default]
    Analytic,
    /// From a table of angles and a table of areas, exact to about 0.002. It takes 1.0 to 1.2 times as long.
    /// Section 4.2.
    Tables,
}
