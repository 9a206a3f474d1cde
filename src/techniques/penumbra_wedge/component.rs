//! What a user sets on a light.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

use crate::silhouettes::NeedsSilhouettes;

/// Gives a light soft shadows by penumbra wedges: noise-free, from geometry, without a shadow map.
///
/// Rectangles and spheres cast with their extent; points, spots and directional lights, and areas of size 0, cast
/// exactly the hard shadow. [`PenumbraWedge::split`] makes several lights of one, which tells better what overlaps.
/// Alpha-tested surfaces cast whole.
///
/// Source: Assarsson, Dougherty, Mounier & Akenine-Möller 2003, "An Optimized Soft Shadow Volume Algorithm with
/// Real-Time Performance"; potential silhouette edges: Laine, Aila, Assarsson, Lehtinen & Akenine-Möller 2005, "Soft
/// Shadow Volumes for Ray Tracing".
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
#[require(NeedsSilhouettes)]
pub struct PenumbraWedge {
    /// Parts of a rectangle along its width and height, each a light of its own; 1 to [`MAX_SPLIT`] (others are
    /// clamped). A sphere is split into as many smaller spheres. Section 5.2.
    pub split: [u32; 2],
    /// Which edges cast.
    pub silhouette: WedgeSilhouette,
    /// How the coverage of several casters combines.
    pub overlap: Overlap,
    /// Where visibility is summed.
    pub buffer: VisibilityBuffer,
    /// What encloses the penumbra of an edge.
    pub bounds: WedgeBounds,
    /// Which pixels the coverage is computed at. The pictures are the same.
    pub culling: WedgeCulling,
    /// How areas are computed.
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

/// Casters that may lie one behind the other while places of [`Overlap::Sampled`] are told in steps.
pub const MOST_IN_STEPS: u32 = 30;

/// Casters that may lie one behind the other in a light with [`Overlap::Sampled`]; of more, shadows may be too light. What a
/// light has is [`LightSilhouettes::stacked`](crate::silhouettes::LightSilhouettes::stacked).
pub const MOST_STACKED: u32 = 254;

/// Largest number of parts along a side of a light.
pub const MAX_SPLIT: u32 = 8;

impl PenumbraWedge {
    /// Parts along width and height, within 1 to [`MAX_SPLIT`].
    pub fn parts(&self) -> [u32; 2] {
        self.split.map(|parts| parts.clamp(1, MAX_SPLIT))
    }

    /// The silhouette that is cast: patches are those of one.
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
pub enum WedgeSilhouette {
    /// The silhouette as each receiver sees it: beside the edges of the silhouette from the centre, those of all
    /// triangles whose plane cuts the light, and at each pixel those count that bound what is before the light there.
    /// Right for any caster by itself, and no facet jumps when the light moves; up to about twice the time, most for
    /// dense meshes. After Laine et al. 2005.
    #[default]
    Receiver,
    /// The silhouette from the centre of the light, or of each of its parts: fewer wedges. What [`Overlap::Paper`] takes.
    Center,
}

/// How the coverage of several casters combines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub enum Overlap {
    /// What is hidden is counted at nine places of the light, soft ones, so that none jumps when the light moves; and told
    /// more finely by the sum of coverages, as far as the sum agrees with the places: exact within 0.03 where nothing
    /// overlaps, and right within what nine places and the sum together tell where much does. One pass. Up to 254 casters may
    /// lie one behind the other ([`MOST_STACKED`]); from 31 on, places jump a little when the light moves.
    ///
    /// Needs a device that blends 32-bit floats, [`VisibilityBuffer::Float`] and a light without texture; else
    /// [`Overlap::Additive`].
    #[default]
    Sampled,
    /// Coverages add up to at most 1: exact for casters that hide different parts of the light.
    Additive,
    /// Between the extremes of no and all overlap: `c = max + ½ min`, loop after loop of all casters. A loop goes with its
    /// holes and the [patch](super::geometry::patches) of triangles that they bound. Patches whose shadows cannot meet share a sum,
    /// and so do others once there are more than [`MAX_SUMS`](super::geometry::patches::MAX_SUMS); a pass a sum. Section 5.1,
    /// equation 1.
    Paper,
}

/// Where visibility is summed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub enum VisibilityBuffer {
    /// A float texture, where the device can blend 32 bits; else [`VisibilityBuffer::Split8`].
    #[default]
    Float,
    /// A texture of half floats, which every device blends. They round, so that the order of casters may show by 0.001,
    /// and cannot hold the counts of [`Overlap::Sampled`], which is [`Overlap::Additive`] then.
    Half,
    /// Twelve bits over the four bytes of two `Rgba8Unorm` textures, one for what adds and one for what subtracts.
    /// Section 4.3.
    Split8,
}

/// What encloses the penumbra of an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub enum WedgeBounds {
    /// The convex hull of the penumbra of the light's own shape.
    #[default]
    Tight,
    /// Tangent planes of the sphere around the light.
    Sphere,
}

/// Which pixels the coverage of an edge is computed at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub enum WedgeCulling {
    /// Where a back face of the wedge lies behind the surface; all wedges in one draw.
    #[default]
    Depth,
    /// Where the surface lies inside of a wedge half, marked in the stencil before; four draws an edge. Section 4.4.
    Stencil,
    /// Where the wedge covers the pixel: what the others are measured against.
    None,
}

/// How areas are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub enum CoverageMaths {
    /// In the shader.
    #[default]
    Analytic,
    /// From a table of angles and a table of areas: to about 0.002. Section 4.2.
    Tables,
}
