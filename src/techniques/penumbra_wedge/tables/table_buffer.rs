//! The layout of the table buffer: angles and sectors first, then the tables of the frame's textures.

use std::sync::Arc;

use glam::Vec3;

use super::lookup::{self, LOOKUP_LENGTH};
use super::texture::{EmitterTexture, LightTexture, TABLE_LENGTH};
use crate::techniques::penumbra_wedge::geometry::records::WedgeLight;
use crate::techniques::penumbra_wedge::light_parts::LightPart;
use crate::techniques::penumbra_wedge::wedges::PenumbraWedges;

/// The content of the table buffer.
#[derive(Debug)]
pub struct Tables {
    entries: Vec<[f32; 4]>,
    placed: Vec<PlacedTables>,
    is_new: bool,
}

/// Position of the tables of all frames of a texture, for one part.
#[derive(Clone, Debug)]
struct PlacedTables {
    texture: Arc<LightTexture>,
    place: [f32; 4],
    first: u32,
    means: Vec<Vec3>,
}

impl Tables {
    /// Makes the tables of angles and sectors.
    pub fn new() -> Self {
        Self {
            entries: lookup::entries(),
            placed: Vec::new(),
            is_new: true,
        }
    }

    /// Returns the content of the buffer.
    pub fn entries(&self) -> &[[f32; 4]] {
        &self.entries
    }

    /// Builds the tables of new textures, drops those of textures that are gone, and writes the positions
    /// into the lights' records. Returns whether the content changed.
    pub fn place(&mut self, world: &PenumbraWedges, records: &mut [WedgeLight]) -> bool {
        let needs = |tables: &PlacedTables| {
            world.lights.iter().any(|light| {
                let texture = light.texture.as_ref();
                texture.is_some_and(|texture| Arc::ptr_eq(&texture.texture, &tables.texture))
            })
        };
        let mut changed = std::mem::take(&mut self.is_new);
        if !self.placed.iter().all(needs) {
            // This is rare, and tables that stay are rebuilt too, because positions are given out in a row.
            self.placed.clear();
            self.entries.truncate(LOOKUP_LENGTH);
        }
        for light in &world.lights {
            let Some(EmitterTexture { texture, frame }) = &light.texture else {
                continue;
            };
            for index in light.parts.clone() {
                let place = world.parts[index].part.place;
                let known = self
                    .placed
                    .iter()
                    .position(|tables| Arc::ptr_eq(&tables.texture, texture) && tables.place == place);
                let at = known.unwrap_or_else(|| {
                    changed = true;
                    let first = self.entries.len() as u32;
                    let frames = (0..texture.frame_count()).map(|frame| texture.tables(frame, place));
                    let means = frames
                        .map(|tables| {
                            self.entries.extend(tables.entries);
                            tables.mean
                        })
                        .collect();
                    self.placed.push(PlacedTables {
                        texture: texture.clone(),
                        place,
                        first,
                        means,
                    });
                    self.placed.len() - 1
                });
                let frame = frame % texture.frame_count();
                records[index].table = self.placed[at].first + (frame * TABLE_LENGTH) as u32;
            }
        }
        changed
    }

    /// Returns what a fully visible part adds to the mask: rgb by colour, alpha by area.
    ///
    /// Shares are whole steps of a half float below 1, the format of the mask, so all parts together give
    /// exactly 1.
    pub fn share(
        &self,
        part: &LightPart,
        texture: Option<&EmitterTexture>,
        number: usize,
        parts: usize,
    ) -> [f64; 4] {
        const STEPS: usize = 2048;
        let until = |number: usize| (number * STEPS + parts / 2) / parts;
        let share = (until(number + 1) - until(number)) as f64 / STEPS as f64;
        let placed = texture.and_then(|texture| {
            let tables = self.placed.iter();
            let mut tables = tables.filter(|tables| Arc::ptr_eq(&tables.texture, &texture.texture));
            let tables = tables.find(|tables| tables.place == part.place)?;
            Some(tables.means[texture.frame % tables.means.len()].as_dvec3() * share)
        });
        placed.map_or([share; 4], |color| color.extend(share).to_array())
    }
}
