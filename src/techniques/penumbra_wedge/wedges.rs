//! The frame's wedges: flat arrays over all lights, rebuilt only where something moved.

use std::ops::Range;

use bevy_ecs::prelude::*;

use super::chunks::{ChunkScratch, LightChunks};
use super::component::PenumbraWedge;
use super::geometry::records::{Wedge, WedgeCaster};
use super::light_parts::LightPart;
use super::part_patches::{PartPatches, Placed};
use super::tables::texture::EmitterTexture;
use crate::techniques::shared::finite_reach::NearestSurfaces;

/// The wedges of this frame, for each light with a [`PenumbraWedge`] that some caster shadows in view, or that has a
/// texture. Written by `build_penumbra_wedges`.
#[derive(Resource, Debug, Default)]
pub struct PenumbraWedges {
    /// Lights with wedges, ascending by light.
    pub lights: Vec<LightWedges>,
    /// Parts of all lights, in the order of the lights.
    pub parts: Vec<PartWedges>,
    /// Groups of all parts. The shadows of a group are summed by themselves. A part has one group or, with
    /// [`Overlap::Paper`](super::Overlap::Paper), as many as it has patches that meet.
    pub groups: Vec<Group>,
    /// Casters of all groups.
    pub casters: Vec<CasterDraw>,
    /// The GPU's records of `casters`, in the same order.
    pub caster_records: Vec<WedgeCaster>,
    /// Wedges of all casters, one per edge or piece of an edge.
    pub wedges: Vec<Wedge>,
    /// Cap triangles of all casters: vertices of their meshes, in the order of the mesh.
    pub caps: Vec<u32>,
    /// Increases when `wedges`, `caps` or the number of casters changed.
    pub generation: u64,
    /// Increases when `caster_records` changed.
    pub casters_generation: u64,
    pub(super) kept: Vec<LightChunks>,
    pub(super) scratch: Scratch,
    pub(super) surfaces: NearestSurfaces,
    pub(super) frame: u64,
}

/// One light with wedges.
#[derive(Clone, Debug, PartialEq)]
pub struct LightWedges {
    /// Index into [`FrameLights`].
    pub light: usize,
    /// Entity of the light.
    pub entity: Entity,
    /// Copy of the light's component.
    pub settings: PenumbraWedge,
    /// Copy of the light's texture component; `None` unless the light is a rectangle.
    pub texture: Option<EmitterTexture>,
    /// Range of [`PenumbraWedges::parts`].
    pub parts: Range<usize>,
    /// Whether some caster differs between the two [layers](super::geometry::silhouette_layers).
    pub is_layered: bool,
    /// Number of casters that lie one behind the other, estimated from bounding boxes.
    pub stacked: u32,
    /// Number of polygons that cut the light but are left out, because the surface of one caster needs too many of them.
    pub cuts_left_out: u32,
}

/// One part of a light.
#[derive(Clone, Debug, PartialEq)]
pub struct PartWedges {
    /// Position and shape of the part.
    pub part: LightPart,
    /// Metres at which the rays of shells end; 0: at infinity.
    pub reach: f32,
    /// Range of [`PenumbraWedges::groups`].
    pub groups: Range<usize>,
}

/// Casters whose shadows are summed together.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Range of [`PenumbraWedges::casters`].
    pub casters: Range<usize>,
    /// Range of [`PenumbraWedges::wedges`] whose faces count where they are in front of the surface.
    pub towards: Range<u32>,
    /// Range of [`PenumbraWedges::wedges`] whose faces count where they are behind the surface.
    pub away: Range<u32>,
}

impl Group {
    /// Range of all wedges of the group.
    pub fn wedges(&self) -> Range<u32> {
        self.towards.start..self.away.end
    }
}

/// One caster of one part of a light.
#[derive(Clone, Debug, PartialEq)]
pub struct CasterDraw {
    /// Dense index of the caster.
    pub object: u32,
    /// Ranges of [`PenumbraWedges::caps`] by layer: facing, averted, both; first those in the mesh's winding, then
    /// those that must be turned. See [layers](super::geometry::silhouette_layers).
    pub caps: [Range<u32>; 6],
    /// True if the caster is counted towards the viewer: it shadows no part of the viewport, and its own
    /// surface hides its caps.
    pub towards: bool,
}

#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub(super) chunk: ChunkScratch,
    pub(super) parts: Vec<LightPart>,
    /// Layout of the flat arrays; `last_layout` is that of the last frame.
    pub(super) layout: Vec<Placed>,
    pub(super) last_layout: Vec<Placed>,
    /// Groups of each part, for which the flat arrays were made.
    pub(super) part_groups: Vec<Range<usize>>,
    pub(super) patches: PartPatches,
}

impl PenumbraWedges {
    /// Returns the wedges of a light of [`FrameLights`](crate::sets::FrameLights).
    pub fn of_light(&self, light: usize) -> Option<&LightWedges> {
        let at = self
            .lights
            .binary_search_by_key(&light, |entry| entry.light)
            .ok()?;
        Some(&self.lights[at])
    }
}
