//! Assembles the frame's flat arrays from the chunks of its casters.

use smallvec::SmallVec;

use super::component::Overlap;
use super::geometry::ends::ENDLESS;
use super::geometry::patches::share_sums;
use super::geometry::records::{Wedge, WedgeCaster};
use super::wedges::{CasterDraw, Group, PenumbraWedges, Scratch};

impl PenumbraWedges {
    /// Copies the chunks into the flat arrays if something `changed`. Otherwise the arrays stay as they are.
    pub(super) fn assemble(&mut self, changed: bool) {
        let Self {
            lights,
            parts,
            groups,
            casters,
            caster_records,
            wedges,
            caps,
            generation,
            casters_generation,
            kept,
            scratch,
            ..
        } = self;
        let Scratch {
            layout,
            part_groups,
            entries,
            cones,
            order,
            sums,
            ..
        } = scratch;
        if !changed {
            for (part, of_part) in parts.iter_mut().zip(part_groups.iter()) {
                part.groups = of_part.clone();
            }
            return;
        }
        *generation += 1;
        *casters_generation += 1;
        groups.clear();
        casters.clear();
        caster_records.clear();
        wedges.clear();
        caps.clear();
        part_groups.clear();
        let mut placed = 0;
        for light in lights.iter() {
            let chunks = kept
                .binary_search_by_key(&light.entity, |entry| entry.light)
                .map_or(&[][..], |at| &kept[at].chunks);
            for index in light.parts.clone() {
                let first = placed;
                placed += layout[first..]
                    .iter()
                    .take_while(|entry| entry.index == index as u32)
                    .count();
                let chunk_of = |at: usize| {
                    let key = (layout[at].caster, layout[at].part);
                    let found = chunks.binary_search_by_key(&key, |chunk| (chunk.entity, chunk.part));
                    found.ok().map(|at| &chunks[at])
                };
                entries.clear();
                cones.clear();
                for at in first..placed {
                    for (number, patch) in chunk_of(at)
                        .into_iter()
                        .flat_map(|chunk| chunk.patches.iter().enumerate())
                    {
                        entries.push((at, number));
                        cones.push(patch.cone);
                    }
                }
                let sum_count = if light.settings.overlap == Overlap::Paper {
                    share_sums(cones, order, sums)
                } else {
                    sums.clear();
                    sums.resize(entries.len(), 0);
                    u32::from(!entries.is_empty())
                };
                let first_group = groups.len();
                for sum in 0..sum_count {
                    let (first_caster, first_wedge) = (casters.len(), wedges.len() as u32);
                    let mut first_away = first_wedge;
                    let (layout, entries, sums) = (&*layout, &*entries, &*sums);
                    let of_sum = |towards: bool| {
                        let of_sum = entries.iter().zip(sums.iter()).filter(|(_, of)| **of == sum);
                        let entries = of_sum.map(|(&entry, _)| entry);
                        entries.filter(move |entry| layout[entry.0].towards == towards)
                    };
                    let mut of_sum = of_sum(true).chain(of_sum(false)).peekable();
                    while let Some(&(at, _)) = of_sum.peek() {
                        let Some(chunk) = chunk_of(at) else {
                            break;
                        };
                        let mut numbers: SmallVec<[usize; 16]> = SmallVec::new();
                        while let Some((_, number)) = of_sum.next_if(|entry| entry.0 == at) {
                            numbers.push(number);
                        }
                        let object = layout[at].object;
                        let caster = caster_records.len() as u32;
                        caster_records.push(WedgeCaster {
                            light_local: chunk.light_local,
                            end_local: ENDLESS,
                            end_light: ENDLESS,
                            object,
                            extrusion: f32::from_bits(layout[at].extrusion),
                            padding: [0; 2],
                        });
                        for &number in &numbers {
                            let own = &chunk.wedges[chunk.patches[number].wedges.clone()];
                            wedges.extend(own.iter().map(|wedge| Wedge { caster, ..*wedge }));
                        }
                        let cap_ranges = std::array::from_fn(|layers| {
                            let first_cap = caps.len() as u32;
                            for &number in &numbers {
                                caps.extend_from_slice(
                                    &chunk.caps[chunk.patches[number].caps[layers].clone()],
                                );
                            }
                            first_cap..caps.len() as u32
                        });
                        casters.push(CasterDraw {
                            object,
                            caps: cap_ranges,
                            towards: layout[at].towards,
                        });
                        if layout[at].towards {
                            first_away = wedges.len() as u32;
                        }
                    }
                    groups.push(Group {
                        casters: first_caster..casters.len(),
                        towards: first_wedge..first_away,
                        away: first_away..wedges.len() as u32,
                    });
                }
                parts[index].groups = first_group..groups.len();
                part_groups.push(parts[index].groups.clone());
            }
        }
    }
}
