//! Textured rectangles, and the tables from which their coverage is looked up.
//!
//! A rectangle is the square from −1 to 1. A projected edge covers the texture's integral over a sector of
//! the square, less the integral over the triangle of the centre and the edge's clipped ends. The sector is
//! the difference of two entries of a table along the border. The triangle is an entry of a table of four
//! dimensions, two for each end.
//!
//! Source: Assarsson et al. 2003, section 4.2.2 and, for animated textures, the 4D coverage texture of their
//! earlier paper. Their table holds the covered part itself, which jumps where the edge passes the centre.
//! The signed integral over the triangle does not jump, so it can be interpolated.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{Vec2, Vec3};

/// Gives a rectangle light with a [`PenumbraWedge`](crate::techniques::penumbra_wedge::PenumbraWedge) the
/// colours of an image: its radiance is that of the light times the texel. Other lights ignore it.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct EmitterTexture {
    /// The images; one for a still light, more for an animated one.
    pub texture: Arc<LightTexture>,
    /// Index of the image that is shown. It wraps around at the number of images.
    pub frame: usize,
}

/// Images of one size. A row runs along the light's X axis; the first row is at the highest Y.
#[derive(Clone, Debug, PartialEq)]
pub struct LightTexture {
    width: usize,
    height: usize,
    frames: Vec<Vec<Vec3>>,
}

/// Why images cannot be the texture of a light.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LightTextureError {
    /// There is no frame, or frames have no texels.
    #[error("a light's texture needs a frame and a texel")]
    Empty,
    /// A frame does not have width × height texels.
    #[error("frame {frame} has {texels} texels, {width} × {height} are needed")]
    Size {
        /// Index of the frame.
        frame: usize,
        /// Number of texels that the frame has.
        texels: usize,
        /// Width in texels.
        width: usize,
        /// Height in texels.
        height: usize,
    },
    /// A texel that is negative, NaN or infinite.
    #[error("frame {frame}, texel {texel} is not finite or negative")]
    Texel {
        /// Index of the frame.
        frame: usize,
        /// Index of the texel; rows from the top.
        texel: usize,
    },
}

/// Number of nodes along each axis of the table of triangles.
pub const NODES: usize = 16;

/// Number of steps along the border. The table of sectors has one entry more.
pub const BORDER_STEPS: usize = 256;

/// Number of entries of both tables: sectors, then triangles.
pub const TABLE_LENGTH: usize = BORDER_STEPS + 1 + NODES * NODES * NODES * NODES;

/// Coverage tables of one frame, for one part of a light.
#[derive(Clone, Debug, PartialEq)]
pub struct CoverageTables {
    /// Mean of the texture over the part, linear RGB.
    pub mean: Vec3,
    /// Shares of the whole light by colour, in xyz; [`TABLE_LENGTH`] entries.
    pub entries: Vec<[f32; 4]>,
}

impl LightTexture {
    /// Takes images of linear RGB texels, rows from the top.
    ///
    /// # Errors
    /// [`LightTextureError`] names the frame and texel.
    pub fn new(width: usize, height: usize, frames: Vec<Vec<Vec3>>) -> Result<Self, LightTextureError> {
        if width == 0 || height == 0 || frames.is_empty() {
            return Err(LightTextureError::Empty);
        }
        for (frame, texels) in frames.iter().enumerate() {
            if texels.len() != width * height {
                return Err(LightTextureError::Size {
                    frame,
                    texels: texels.len(),
                    width,
                    height,
                });
            }
            let usable = |texel: &Vec3| texel.is_finite() && texel.min_element() >= 0.0;
            if let Some(texel) = texels.iter().position(|texel| !usable(texel)) {
                return Err(LightTextureError::Texel { frame, texel });
            }
        }
        Ok(Self {
            width,
            height,
            frames,
        })
    }

    /// Number of images.
    pub fn frame_count(&self) -> usize {
        self.frames.len()
    }

    /// Returns the texel nearest to a place in light space, −1 to 1 along the light's X and Y.
    pub fn texel(&self, frame: usize, place: Vec2) -> Vec3 {
        let at = |x: f32, size: usize| ((x * size as f32) as usize).min(size - 1);
        let (u, v) = (place.x * 0.5 + 0.5, 0.5 - place.y * 0.5);
        let frame = &self.frames[frame % self.frames.len()];
        frame[at(v.max(0.0), self.height) * self.width + at(u.max(0.0), self.width)]
    }

    /// Makes the tables of the part at `place`: its centre and half size within the light, which spans −1 to
    /// 1.
    pub fn tables(&self, frame: usize, place: [f32; 4]) -> CoverageTables {
        let [x, y, half_x, half_y] = place;
        let texel = |p: Vec2| self.texel(frame, Vec2::new(x, y) + p * Vec2::new(half_x, half_y));
        let rays = RayIntegrals::new(&texel);
        let mut entries = Vec::with_capacity(TABLE_LENGTH);
        let mut sum = Vec3::ZERO;
        entries.push(sum);
        for step in 0..BORDER_STEPS {
            // The border is 8 long, and each step along it is as wide as its sector.
            let at = border_point((step as f32 + 0.5) * (8.0 / BORDER_STEPS as f32));
            sum += rays.at(at) * (8.0 / BORDER_STEPS as f32);
            entries.push(sum);
        }
        let node = |i: usize| i as f32 * (2.0 / (NODES - 1) as f32) - 1.0;
        for second in 0..NODES * NODES {
            let end = Vec2::new(node(second % NODES), node(second / NODES));
            for first in 0..NODES * NODES {
                let start = Vec2::new(node(first % NODES), node(first / NODES));
                entries.push(rays.triangle(start, end));
            }
        }
        // A texture without light is dark, however it is shared.
        let whole = sum.max(Vec3::splat(1e-20));
        CoverageTables {
            mean: sum * 0.25,
            entries: entries
                .into_iter()
                .map(|entry| (entry / whole).extend(0.0).to_array())
                .collect(),
        }
    }
}

/// Returns the point of the square's border at a place along it. `border_place` of
/// `shaders/common/coverage.wgsl` is the inverse.
fn border_point(place: f32) -> Vec2 {
    let place = (place + 1.0).rem_euclid(8.0) - 1.0;
    if place < 1.0 {
        Vec2::new(1.0, place)
    } else if place < 3.0 {
        Vec2::new(2.0 - place, 1.0)
    } else if place < 5.0 {
        Vec2::new(-1.0, 4.0 - place)
    } else {
        Vec2::new(place - 6.0, -1.0)
    }
}

/// `∫₀¹ λ T(λ x) dλ` on a grid over the square. Its mean along an edge, times the cross product of the edge's
/// ends, is the integral of T over the triangle of the edge and the centre.
struct RayIntegrals(Vec<Vec3>);

impl RayIntegrals {
    const SIDE: usize = 65;
    const STEPS: usize = 48;

    fn new(texel: &impl Fn(Vec2) -> Vec3) -> Self {
        let node = |i: usize| i as f32 * (2.0 / (Self::SIDE - 1) as f32) - 1.0;
        let integral = |at: Vec2| {
            let steps = Self::STEPS as f32;
            (0..Self::STEPS)
                .map(|step| (step as f32 + 0.5) / steps)
                .map(|share| texel(at * share) * (share / steps))
                .sum()
        };
        let nodes =
            (0..Self::SIDE * Self::SIDE).map(|i| Vec2::new(node(i % Self::SIDE), node(i / Self::SIDE)));
        Self(nodes.map(integral).collect())
    }

    fn at(&self, place: Vec2) -> Vec3 {
        let scaled = (place * 0.5 + 0.5) * (Self::SIDE - 1) as f32;
        let cell = scaled
            .floor()
            .clamp(Vec2::ZERO, Vec2::splat((Self::SIDE - 2) as f32));
        let share = scaled - cell;
        let first = cell.y as usize * Self::SIDE + cell.x as usize;
        let row = |at: usize| self.0[at].lerp(self.0[at + 1], share.x);
        row(first).lerp(row(first + Self::SIDE), share.y)
    }

    fn triangle(&self, start: Vec2, end: Vec2) -> Vec3 {
        const STEPS: usize = 12;
        let along = |step: usize| start.lerp(end, (step as f32 + 0.5) / STEPS as f32);
        let mean: Vec3 = (0..STEPS).map(|step| self.at(along(step)) / STEPS as f32).sum();
        mean * start.perp_dot(end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_white_texture_gives_areas() {
        let white = LightTexture::new(1, 1, vec![vec![Vec3::ONE]]).unwrap();
        let tables = white.tables(0, [0.0, 0.0, 1.0, 1.0]);
        assert_eq!(tables.entries.len(), TABLE_LENGTH);
        assert!((tables.mean - Vec3::ONE).abs().max_element() < 1e-4);
        assert!((tables.entries[BORDER_STEPS / 4][0] - 0.25).abs() < 1e-4);
        // From the corner (−1, −1) to the corner (1, −1): a quarter of the square.
        let corner = BORDER_STEPS + 1 + (NODES - 1) * NODES * NODES;
        assert!(
            (tables.entries[corner][1] - 0.25).abs() < 1e-3,
            "{:?}",
            tables.entries[corner]
        );
    }

    #[test]
    fn bad_textures_are_named() {
        assert_eq!(LightTexture::new(0, 1, vec![]), Err(LightTextureError::Empty));
        let error = LightTexture::new(1, 1, vec![vec![Vec3::ONE], vec![Vec3::NAN]]);
        assert_eq!(error, Err(LightTextureError::Texel { frame: 1, texel: 0 }));
        let error = LightTexture::new(2, 1, vec![vec![Vec3::ONE]]).unwrap_err();
        assert_eq!(error.to_string(), "frame 0 has 1 texels, 2 × 1 are needed");
    }
}
