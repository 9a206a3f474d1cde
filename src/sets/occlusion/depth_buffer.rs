//! A picture of how near something surely stands, and the test of boxes against it.

use glam::DVec3;
use wide::f32x8;

use super::projection::{BoxImage, Projection};

/// Texels along each side of a tile.
const TILE: usize = 8;

/// Keys must differ by this part of themselves for one surface to hide another.
const KEY_MARGIN: f64 = 1e-4;

/// By texel, the key such that at every point of the texel something stands at least that near; by tile of 8 × 8, the
/// smallest of its texels' keys.
#[derive(Clone, Debug)]
pub struct DepthBuffer {
    projection: Projection,
    stride: usize,
    texels: Vec<f32>,
    tile_stride: usize,
    tiles: Vec<f32>,
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
        };
        buffer.reset(projection);
        buffer
    }

    /// Empties the buffer for another view; keeps its memory.
    pub fn reset(&mut self, projection: Projection) {
        let [width, height] = projection.size.to_array().map(|size| size as usize);
        self.projection = projection;
        self.tile_stride = width.div_ceil(TILE);
        self.stride = self.tile_stride * TILE;
        self.texels.clear();
        self.texels.resize(self.stride * height.div_ceil(TILE) * TILE, f32::NEG_INFINITY);
        self.tiles.clear();
        self.tiles
            .resize(self.tile_stride * height.div_ceil(TILE), f32::NEG_INFINITY);
    }

    /// The picture's projection.
    pub fn projection(&self) -> &Projection {
        &self.projection
    }

    /// Texels from one row to the next; a multiple of eight.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Key of a texel; minus infinity where nothing is known to stand.
    pub fn texel(&self, column: usize, row: usize) -> f32 {
        self.texels[row * self.stride + column]
    }

    /// Share of texels that something covers.
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

    /// Computes the tiles, once all occluders are drawn.
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
            let lowest = (0..TILE).fold(f32x8::splat(f32::INFINITY), |lowest, line| {
                let first = (row * TILE + line) * self.stride + column * TILE;
                lowest.fast_min(load(&self.texels[first..first + TILE]))
            });
            *tile = lowest.to_array().into_iter().fold(f32::INFINITY, f32::min);
        }
    }

    /// Whether nothing of a box can be seen in the picture: it is behind what is there, or out of the picture of a
    /// perspective view.
    pub fn hides(&self, center: DVec3, half: DVec3) -> bool {
        match self.projection.image_of_box(center, half) {
            Some(image) if self.projection.is_parallel() => {
                // What lies beside the picture is not known.
                image.is_within(&self.projection) && self.hides_image(&image)
            }
            Some(image) => self.hides_image(&image),
            None => !self.projection.is_parallel(),
        }
    }

    fn hides_image(&self, image: &BoxImage) -> bool {
        let key = image.key + image.key.abs() * KEY_MARGIN + self.projection.key_quantum;
        let key = key as f32 + key.abs() as f32 * f32::EPSILON;
        let texels = |(low, high): (f64, f64), count: u32| {
            let last = f64::from(count) - 1.0;
            let slack = f64::from(super::raster::SLACK);
            let first = (low - slack).floor().clamp(0.0, last);
            (first as usize, (high + slack).floor().clamp(0.0, last) as usize)
        };
        if !(image.x.0 <= image.x.1 && image.y.0 <= image.y.1 && key.is_finite()) {
            return false;
        }
        let (columns, rows) = (
            texels(image.x, self.projection.size.x),
            texels(image.y, self.projection.size.y),
        );
        for tile_row in rows.0 / TILE..=rows.1 / TILE {
            for tile_column in columns.0 / TILE..=columns.1 / TILE {
                if self.tiles[tile_row * self.tile_stride + tile_column] > key {
                    continue;
                }
                let first = tile_column * TILE;
                let lanes = (0..TILE).filter(|lane| (columns.0..=columns.1).contains(&(first + lane)));
                let mask: u32 = lanes.map(|lane| 1 << lane).sum();
                let lines = rows.0.max(tile_row * TILE)..=rows.1.min(tile_row * TILE + TILE - 1);
                for row in lines {
                    let at = row * self.stride + first;
                    let nearer = load(&self.texels[at..at + TILE]).simd_gt(f32x8::splat(key));
                    if nearer.to_bitmask() & mask != mask {
                        return false;
                    }
                }
            }
        }
        true
    }
}

fn load(texels: &[f32]) -> f32x8 {
    let mut lanes = [0.0; TILE];
    lanes.copy_from_slice(texels);
    f32x8::new(lanes)
}
