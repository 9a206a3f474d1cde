//! The patches of the casters of one part of a light, and the sums that their shadows are added to.

use bevy_ecs::prelude::*;

use super::chunks::Chunk;
use super::component::Overlap;
use super::geometry::patches::{ShadowCone, share_sums};

/// A chunk's place in the flat arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Placed {
    pub(super) light: Entity,
    /// Number of the part in its light.
    pub(super) part: u32,
    /// Index of the part in the frame.
    pub(super) index: u32,
    pub(super) caster: Entity,
    pub(super) object: u32,
    pub(super) towards: bool,
    /// Bits of [`WedgeCaster::extrusion`](super::geometry::records::WedgeCaster::extrusion).
    pub(super) extrusion: u32,
}

/// The casters of one part, in the order in which they were placed, and the chunks of the part's light.
pub(super) struct PlacedChunks<'a> {
    pub(super) layout: &'a [Placed],
    /// Ascending by entity and part.
    pub(super) chunks: &'a [Chunk],
}

impl PlacedChunks<'_> {
    /// Returns the chunk of a caster of the layout.
    pub(super) fn chunk(&self, at: usize) -> Option<&Chunk> {
        let key = (self.layout[at].caster, self.layout[at].part);
        let chunks = self.chunks;
        let found = chunks.binary_search_by_key(&key, |chunk| (chunk.entity, chunk.part));
        found.ok().map(|at| &chunks[at])
    }
}

/// The patches of one part, each with the sum that its shadow is added to. Its buffers are reused for every part.
#[derive(Debug, Default)]
pub(super) struct PartPatches {
    /// Index of the patch's caster in the layout of the part, and number of the patch in its chunk.
    entries: Vec<(usize, usize)>,
    /// Directions of the patches' shadows.
    cones: Vec<ShadowCone>,
    /// Order in which patches get sums.
    order: Vec<u32>,
    /// Sum of each patch.
    sums: Vec<u32>,
}

impl PartPatches {
    /// Collects the patches of a part and gives each its sum. Returns the number of sums.
    pub(super) fn share(&mut self, placed: &PlacedChunks<'_>, overlap: Overlap) -> u32 {
        self.entries.clear();
        self.cones.clear();
        for at in 0..placed.layout.len() {
            let patches = placed.chunk(at).map_or(&[][..], |chunk| &chunk.patches);
            self.entries.extend((0..patches.len()).map(|number| (at, number)));
            self.cones.extend(patches.iter().map(|patch| patch.cone));
        }
        if overlap == Overlap::Paper {
            return share_sums(&self.cones, &mut self.order, &mut self.sums);
        }
        self.sums.clear();
        self.sums.resize(self.entries.len(), 0);
        u32::from(!self.entries.is_empty())
    }

    /// Returns the patches of a sum whose casters are counted `towards` the viewer, or those whose are not.
    pub(super) fn of_sum<'a>(
        &'a self,
        layout: &'a [Placed],
        sum: u32,
        towards: bool,
    ) -> impl Iterator<Item = (usize, usize)> + 'a {
        let entries = self.entries.iter().zip(&self.sums);
        entries
            .filter(move |(entry, of)| **of == sum && layout[entry.0].towards == towards)
            .map(|(entry, _)| *entry)
    }
}
