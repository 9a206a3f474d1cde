//! Assembles the frame's flat arrays from the chunks of its casters.

use std::ops::Range;

use smallvec::SmallVec;

use super::chunks::Chunk;
use super::geometry::ends::ENDLESS;
use super::geometry::records::{Wedge, WedgeCaster};
use super::part_patches::{PartPatches, Placed, PlacedChunks};
use super::wedges::{CasterDraw, Group, PenumbraWedges, Scratch};

impl PenumbraWedges {
    /// Copies the chunks into the flat arrays if something `changed`. Otherwise the arrays stay as they are.
    pub(super) fn assemble(&mut self, changed: bool) {
        let Self {
            lights,
            parts,
            kept,
            scratch,
            ..
        } = self;
        let Scratch {
            layout,
            part_groups,
            patches,
            ..
        } = scratch;
        if !changed {
            for (part, of_part) in parts.iter_mut().zip(part_groups.iter()) {
                part.groups = of_part.clone();
            }
            return;
        }
        self.generation += 1;
        self.casters_generation += 1;
        part_groups.clear();
        let mut arrays = FlatArrays {
            groups: &mut self.groups,
            casters: &mut self.casters,
            caster_records: &mut self.caster_records,
            wedges: &mut self.wedges,
            caps: &mut self.caps,
        };
        arrays.clear();
        let mut rest = &layout[..];
        for light in lights.iter() {
            let chunks = kept
                .binary_search_by_key(&light.entity, |entry| entry.light)
                .map_or(&[][..], |at| &kept[at].chunks);
            for index in light.parts.clone() {
                let count = rest.partition_point(|placed| placed.index <= index as u32);
                let of_part;
                (of_part, rest) = rest.split_at(count);
                let placed = PlacedChunks {
                    layout: of_part,
                    chunks,
                };
                let sums = patches.share(&placed, light.settings.overlap);
                parts[index].groups = arrays.push_part(&placed, patches, sums);
                part_groups.push(parts[index].groups.clone());
            }
        }
    }
}

/// The arrays of [`PenumbraWedges`] that are filled here.
struct FlatArrays<'a> {
    groups: &'a mut Vec<Group>,
    casters: &'a mut Vec<CasterDraw>,
    caster_records: &'a mut Vec<WedgeCaster>,
    wedges: &'a mut Vec<Wedge>,
    caps: &'a mut Vec<u32>,
}

impl FlatArrays<'_> {
    fn clear(&mut self) {
        self.groups.clear();
        self.casters.clear();
        self.caster_records.clear();
        self.wedges.clear();
        self.caps.clear();
    }

    /// Appends one group for each of the `sums`, and returns the range of the groups.
    fn push_part(&mut self, placed: &PlacedChunks<'_>, patches: &PartPatches, sums: u32) -> Range<usize> {
        let first_group = self.groups.len();
        for sum in 0..sums {
            let (first_caster, first_wedge) = (self.casters.len(), self.wedges.len() as u32);
            self.push_casters(placed, patches.of_sum(placed.layout, sum, true));
            let first_away = self.wedges.len() as u32;
            self.push_casters(placed, patches.of_sum(placed.layout, sum, false));
            self.groups.push(Group {
                casters: first_caster..self.casters.len(),
                towards: first_wedge..first_away,
                away: first_away..self.wedges.len() as u32,
            });
        }
        first_group..self.groups.len()
    }

    /// Appends patches, which are ascending by caster: one caster for all patches that it has among them.
    fn push_casters(&mut self, placed: &PlacedChunks<'_>, patches: impl Iterator<Item = (usize, usize)>) {
        let mut patches = patches.peekable();
        while let Some(&(at, _)) = patches.peek() {
            let mut numbers: SmallVec<[usize; 16]> = SmallVec::new();
            while let Some((_, number)) = patches.next_if(|patch| patch.0 == at) {
                numbers.push(number);
            }
            if let Some(chunk) = placed.chunk(at) {
                self.push_caster(&placed.layout[at], chunk, &numbers);
            }
        }
    }

    fn push_caster(&mut self, placed: &Placed, chunk: &Chunk, patches: &[usize]) {
        let caster = self.caster_records.len() as u32;
        self.caster_records.push(WedgeCaster {
            light_local: chunk.light_local,
            end_local: ENDLESS,
            end_light: ENDLESS,
            object: placed.object,
            extrusion: f32::from_bits(placed.extrusion),
            padding: [0; 2],
        });
        for &patch in patches {
            let own = &chunk.wedges[chunk.patches[patch].wedges.clone()];
            self.wedges
                .extend(own.iter().map(|wedge| Wedge { caster, ..*wedge }));
        }
        let caps = std::array::from_fn(|layers| {
            let first_cap = self.caps.len() as u32;
            for &patch in patches {
                let own = chunk.patches[patch].caps[layers].clone();
                self.caps.extend_from_slice(&chunk.caps[own]);
            }
            first_cap..self.caps.len() as u32
        });
        self.casters.push(CasterDraw {
            object: placed.object,
            caps,
            towards: placed.towards,
        });
    }
}
