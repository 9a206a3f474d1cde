//! A picture of how near something certainly stands, and the test of boxes against it.

use glam::DVec3;
use wide::f32x8;

use super::beam::{Beam, Beams};
use super::projection::Projection;
use crate::geometry::Aabb;

/// Texels along each side of a tile.
const TILE: usize = 8;

/// Share of themselves by which keys must differ for one surface to hide another.
const KEY_MARGIN: f64 = 1e-4;

/// A conservative depth buffer. Each texel holds a key such that at every point of the texel a surface stands
/// at least that near. Each tile of 8 × 8 texels holds the smallest and the greatest of its texels' keys.
#[derive(Clone, Debug)]
pub struct DepthBuffer {
    projection: Projection,
    stride: usize,
    texels: Vec<f32>,
    tile_stride: usize,
    tiles: Vec<(f32, f32)>,
    beams: Option<Beams>,
}

impl DepthBuffer {
    /// An empty buffer.
    pub fn new(projection: Projection) -> Self {
        let mut buffer = Self {
            projection,
            stride: 0,
            texels: Vec::new(),
            tile_stride: 0,
            tiles: Vec::new(),
            beams: None,
        };
        buffer.reset(projection);
        buffer
    }

    /// Empties the buffer for another view. It keeps its memory.
    pub fn reset(&mut self, projection: Projection) {
        let [width, height] = projection.size.to_array().map(|size| size as usize);
        self.projection = projection;
        self.beams = Beams::new(&projection);
        self.tile_stride = width.div_ceil(TILE);
        self.stride = self.tile_stride * TILE;
        self.texels.clear();
        self.texels
            .resize(self.stride * height.div_ceil(TILE) * TILE, f32::NEG_INFINITY);
        self.tiles.clear();
        self.tiles.resize(
            self.tile_stride * height.div_ceil(TILE),
            (f32::NEG_INFINITY, f32::NEG_INFINITY),
        );
    }

    /// The picture's projection.
    pub fn projection(&self) -> &Projection {
        &self.projection
    }

    /// Texels from one row to the next; a multiple of eight.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Key of a texel. Minus infinity where nothing is known to stand.
    pub fn texel(&self, column: usize, row: usize) -> f32 {
        self.texels[row * self.stride + column]
    }

    /// Share of the texels that something covers.
    pub fn coverage(&self) -> f64 {
        let [width, height] = self.projection.size.to_array().map(|size| size as usize);
        let covered = (0..height)
            .flat_map(|row| &self.texels[row * self.stride..row * self.stride + width])
            .filter(|key| **key > f32::NEG_INFINITY)
            .count();
        covered as f64 / (width * height) as f64
    }

    pub(super) fn cover(&mut self, column: usize, row: usize, key: f32) {
        let texel = &mut self.texels[row * self.stride + column];
        *texel = texel.max(key);
    }

    /// Computes the tiles. Call this once all occluders are drawn.
    pub fn finish(&mut self) {
        let [width, height] = self.projection.size.to_array().map(|size| size as usize);
        // Texels beyond the picture's edge are in no box.
        for row in 0..self.texels.len() / self.stride.max(1) {
            let line = &mut self.texels[row * self.stride..(row + 1) * self.stride];
            let first = if row < height { width } else { 0 };
            line[first..].fill(f32::INFINITY);
        }
        for (index, tile) in self.tiles.iter_mut().enumerate() {
            let (column, row) = (index % self.tile_stride, index / self.tile_stride);
            let (mut lowest, mut highest) = (f32x8::splat(f32::INFINITY), f32x8::splat(f32::NEG_INFINITY));
            for line in 0..TILE {
                let first = (row * TILE + line) * self.stride + column * TILE;
                let texels = load(&self.texels[first..first + TILE]);
                lowest = lowest.fast_min(texels);
                highest = highest.fast_max(texels);
            }
            *tile = (
                lowest.to_array().into_iter().fold(f32::INFINITY, f32::min),
                highest.to_array().into_iter().fold(f32::NEG_INFINITY, f32::max),
            );
        }
    }

    /// Whether nothing of a box can be visible in the picture: the box is behind drawn surfaces, or outside a
    /// perspective picture.
    pub fn hides(&self, center: DVec3, half: DVec3) -> bool {
        self.look(center, half, &mut |_, _| false)
    }

    /// The box around the part of a box that may be visible. It is empty if no part may be visible.
    pub fn visible_part(&self, center: DVec3, half: DVec3) -> Aabb {
        let mut part = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let whole = (
            center - half - self.projection.origin(),
            center + half - self.projection.origin(),
        );
        let hidden = self.look(center, half, &mut |low, high| {
            part = (part.0.min(low.max(whole.0)), part.1.max(high.min(whole.1)));
            part != whole
        });
        if hidden && !part.0.cmple(part.1).all() {
            return Aabb::EMPTY;
        }
        if !hidden {
            part = whole;
        }
        let origin = self.projection.origin();
        Aabb {
            min: (part.0 + origin).as_vec3(),
            max: (part.1 + origin).as_vec3(),
        }
        .padded()
    }

    /// Visits boxes around the parts of a box that each texel may show. A tile that nothing covers is visited
    /// as a whole. The boxes are relative to the projection's origin. `visit` returns whether to continue.
    /// The result is `false` if `visit` ended the search or if the whole box may be visible.
    fn look(&self, center: DVec3, half: DVec3, visit: &mut dyn FnMut(DVec3, DVec3) -> bool) -> bool {
        let parallel = self.projection.is_parallel();
        let Some(image) = self.projection.image_of_box(center, half) else {
            return !parallel;
        };
        let Some(beams) = &self.beams else { return false };
        // Nothing is known about the space beside a parallel picture.
        if parallel && !image.is_within(&self.projection) {
            return false;
        }
        let texels = |(low, high): (f64, f64), count: u32| {
            let last = f64::from(count) - 1.0;
            let slack = f64::from(super::projection::SLACK);
            let first = (low - slack).floor().clamp(0.0, last);
            (first as usize, (high + slack).floor().clamp(0.0, last) as usize)
        };
        if !(image.x.0 <= image.x.1 && image.y.0 <= image.y.1) {
            return false;
        }
        let (columns, rows) = (
            texels(image.x, self.projection.size.x),
            texels(image.y, self.projection.size.y),
        );
        let origin = self.projection.origin();
        let search = Search {
            buffer: self,
            beams,
            min: center - half - origin,
            max: center + half - origin,
            nearest: self.margin(image.key),
        };
        for tile_row in rows.0 / TILE..=rows.1 / TILE {
            for tile_column in columns.0 / TILE..=columns.1 / TILE {
                let columns = (
                    columns.0.max(tile_column * TILE),
                    columns.1.min(tile_column * TILE + TILE - 1),
                );
                let rows = (
                    rows.0.max(tile_row * TILE),
                    rows.1.min(tile_row * TILE + TILE - 1),
                );
                if !search.tile(tile_row * self.tile_stride + tile_column, columns, rows, visit) {
                    return false;
                }
            }
        }
        true
    }

    /// The key that an occluder must exceed to hide a surface with `key`.
    fn margin(&self, key: f64) -> f64 {
        let key = key + key.abs() * KEY_MARGIN + self.projection.key_quantum;
        if key.is_nan() { f64::INFINITY } else { key }
    }
}

/// The search for a box in a buffer.
struct Search<'a> {
    buffer: &'a DepthBuffer,
    beams: &'a Beams,
    min: DVec3,
    max: DVec3,
    /// The key that hides the whole box.
    nearest: f64,
}

impl Search<'_> {
    /// Searches one tile, within inclusive ranges of columns and rows. `false` ends the search.
    fn tile(
        &self,
        tile: usize,
        columns: (usize, usize),
        rows: (usize, usize),
        visit: &mut dyn FnMut(DVec3, DVec3) -> bool,
    ) -> bool {
        let (lowest, highest) = self.buffer.tiles[tile];
        if f64::from(lowest) > self.nearest {
            return true;
        }
        let beam = self.beam(columns, rows);
        let Some((s0, s1)) = self.depths(&beam) else {
            return true;
        };
        if f64::from(lowest) > self.buffer.margin(self.key(s0)) {
            return true;
        }
        if highest == f32::NEG_INFINITY {
            let (low, high) = beam.bounds(s0, s1);
            return visit(low, high);
        }
        for row in rows.0..=rows.1 {
            let at = row * self.buffer.stride + columns.0 / TILE * TILE;
            let nearer = load(&self.buffer.texels[at..at + TILE])
                .simd_gt(f32x8::splat(self.nearest as f32 * (1.0 + f32::EPSILON)));
            let hidden = nearer.to_bitmask();
            for column in columns.0..=columns.1 {
                if self.nearest > 0.0 && hidden >> (column % TILE) & 1 != 0 {
                    continue;
                }
                let beam = self.beam((column, column), (row, row));
                let Some((s0, s1)) = self.depths(&beam) else {
                    continue;
                };
                let texel = f64::from(self.buffer.texel(column, row));
                if texel > self.buffer.margin(self.key(s0)) {
                    continue;
                }
                // Nothing farther than the surface that covers the texel is visible, up to the margin.
                let s1 = if texel > f64::NEG_INFINITY {
                    s1.min(self.depth_beyond(texel)).max(s0)
                } else {
                    s1
                };
                let (low, high) = beam.bounds(s0, s1);
                if !visit(low, high) {
                    return false;
                }
            }
        }
        true
    }

    fn beam(&self, columns: (usize, usize), rows: (usize, usize)) -> Beam {
        let slack = f64::from(super::projection::SLACK);
        let range = |(first, last): (usize, usize)| (first as f64 - slack, last as f64 + 1.0 + slack);
        self.beams.beam(range(columns), range(rows))
    }

    fn depths(&self, beam: &Beam) -> Option<(f64, f64)> {
        let from = if self.buffer.projection.is_parallel() {
            f64::NEG_INFINITY
        } else {
            self.buffer.projection.near()
        };
        let (s0, s1) = beam.depths(self.min, self.max, from, f64::MAX)?;
        s0.is_finite().then_some((s0, s1))
    }

    fn key(&self, depth: f64) -> f64 {
        if self.buffer.projection.is_parallel() {
            -depth
        } else {
            1.0 / depth
        }
    }

    /// A depth beyond which every surface is certainly hidden by a surface with this key, including the
    /// margin.
    fn depth_beyond(&self, key: f64) -> f64 {
        let quantum = self.buffer.projection.key_quantum;
        if self.buffer.projection.is_parallel() {
            return -key + 2.0 * (key.abs() * KEY_MARGIN + quantum);
        }
        let key = key * (1.0 - 2.0 * KEY_MARGIN) - quantum;
        if key > 0.0 { 1.0 / key } else { f64::MAX }
    }
}

fn load(texels: &[f32]) -> f32x8 {
    let mut lanes = [0.0; TILE];
    lanes.copy_from_slice(texels);
    f32x8::new(lanes)
}
