//! Means over rectangles of a slice's picture by the three filters: twin of
//! `shaders/techniques/occlusion_texture/{filter,resolve}.wgsl`.
//!
//! Sources: Décoret 2005, "N-Buffers for efficient depth map query"; Williams 1983, "Pyramidal parametrics"; Crow 1984,
//! "Summed-area tables for texture mapping". Eisemann & Décoret 2008, §3.2, uses them as here.

use glam::{IVec2, Vec2};

use super::kernel::Kernel;

/// Most squares of which a lookup in N-buffers puts a long rectangle together. Rectangles that are longer are widened.
pub const MOST_TAPS: u32 = 8;

/// A square picture of one slice, 0 where nothing blocks and 1 where something does; rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Texels along a side.
    pub side: usize,
    /// The texels.
    pub texels: Vec<f32>,
}

impl Picture {
    /// Makes a picture from a function of the texel.
    pub fn from_fn(side: usize, of: impl Fn(IVec2) -> f32) -> Self {
        let texel = |index: usize| of(IVec2::new((index % side) as i32, (index / side) as i32));
        Self {
            side,
            texels: (0..side * side).map(texel).collect(),
        }
    }

    /// Returns a texel; 0 outside the picture.
    pub fn at(&self, texel: IVec2) -> f32 {
        let inside = texel.cmpge(IVec2::ZERO).all() && texel.cmplt(IVec2::splat(self.side as i32)).all();
        if inside {
            self.texels[texel.y as usize * self.side + texel.x as usize]
        } else {
            0.0
        }
    }

    /// Returns the mean of four texels that are `step` apart.
    fn mean_of_four(&self, texel: IVec2, step: i32) -> f32 {
        let at = |x, y| self.at(texel + step * IVec2::new(x, y));
        0.25 * ((at(0, 0) + at(1, 0)) + (at(0, 1) + at(1, 1)))
    }

    /// Returns the bilinear mean of the four texels around a place in texels. Places beyond the border get its texels.
    fn sample(&self, place: Vec2) -> f32 {
        let corner = place - 0.5;
        let between = corner - corner.floor();
        let last = IVec2::splat(self.side as i32 - 1);
        let texel = |x, y| self.at((corner.floor().as_ivec2() + IVec2::new(x, y)).clamp(IVec2::ZERO, last));
        let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
        let top = mix(texel(0, 0), texel(1, 0), between.x);
        let bottom = mix(texel(0, 1), texel(1, 1), between.x);
        mix(top, bottom, between.y)
    }
}

/// Number of levels of a picture: the last one is the mean over the whole picture.
pub fn level_count(side: u32) -> u32 {
    side.max(1).ilog2() + 1
}

/// Highest level of N-buffers that has a value at every texel. Each level above has half as many values along a side as the
/// level below, and lookups interpolate between them: the mean over a large square changes little from texel to texel.
///
/// By measure: with 3, squares have eight values along each side. Their means err by up to 0.004 (root mean square), single ones
/// by 0.04, and errors against the ray caster are those of values at every texel to within 0.001. With 2, a single mean errs by up
/// to 0.12; with 4, by up to 0.02, but levels take a third longer to build.
/// `cargo test --all-features --test core sparse_levels -- --nocapture` prints errors of random pictures for the value below.
pub const DENSE_LEVEL: u32 = 3;

/// Returns the distance between the values of a level of N-buffers, in texels of the picture.
pub fn spacing(level: u32) -> u32 {
    1 << level.saturating_sub(DENSE_LEVEL)
}

/// Returns the levels of the N-buffer of a picture. Level `l` holds means over squares of 2^l × 2^l texels, which begin
/// [`spacing`] texels apart. What is outside the picture counts as 0.
pub fn n_buffers(picture: Picture) -> Vec<Picture> {
    let count = level_count(picture.side as u32);
    let mut levels = vec![picture];
    for level in 1..count {
        let below = &levels[level as usize - 1];
        let scale = spacing(level) / spacing(level - 1);
        // Squares of the level below lie beside each other.
        let step = (1 << (level - 1)) / spacing(level - 1) as i32;
        let next = Picture::from_fn(below.side / scale as usize, |texel| {
            below.mean_of_four(scale as i32 * texel, step)
        });
        levels.push(next);
    }
    levels
}

/// Returns what each slice covers, what it and all slices before it cover together, and what was drawn: 2 less the depth of casters
/// below the top of their slice, in thicknesses of the slice, where there are casters.
pub fn split(drawn: &[Picture]) -> [Vec<Picture>; 3] {
    let covered = |value: f32| f32::from(u8::from(value > 0.0));
    let of = |picture: &Picture| Picture {
        side: picture.side,
        texels: picture.texels.iter().map(|texel| covered(*texel)).collect(),
    };
    let coverage: Vec<Picture> = drawn.iter().map(of).collect();
    let mut unions: Vec<Picture> = Vec::with_capacity(drawn.len());
    for picture in &coverage {
        let mut union = picture.clone();
        let before = unions.last().map_or(&picture.texels, |before| &before.texels);
        for (texel, before) in union.texels.iter_mut().zip(before) {
            *texel = texel.max(*before);
        }
        unions.push(union);
    }
    [coverage, unions, drawn.to_vec()]
}

/// Returns the part of a kernel that is as wide as the picture at most, moved to where the kernel covers the picture, and its
/// share of the kernel.
fn narrowed(kernel: &Kernel) -> (Kernel, f32) {
    let room = (kernel.half - 0.5).max(Vec2::ZERO);
    let part = Kernel {
        center: kernel.center - (kernel.center - 0.5).clamp(-room, room),
        half: kernel.half.min(Vec2::splat(0.5)),
    };
    let wider = (2.0 * kernel.half).max(Vec2::ONE);
    (part, 1.0 / (wider.x * wider.y))
}

/// Returns the share of a kernel around the nearest place inside the picture that a kernel beyond the border still
/// reaches.
pub fn share_inside(kernel: &Kernel, half_texel: f32) -> f32 {
    let beyond = (kernel.center - 0.5).abs() - 0.5;
    let left = 1.0 - (beyond / kernel.half.max(Vec2::splat(half_texel))).max(Vec2::ZERO);
    left.x.max(0.0) * left.y.max(0.0)
}

/// Number of squares that the rectangular kernels of a light need, for sides in texels.
pub fn tap_count(size: Vec2) -> u32 {
    let aspect = size.max_element() / size.min_element().max(1e-20);
    ((aspect - 1e-3).ceil().max(1.0) as u32).min(MOST_TAPS)
}

/// Side of the squares of which a lookup in N-buffers puts a kernel together, for sides in texels.
fn square_side(size: Vec2, taps: u32) -> f32 {
    let long = size.max_element().max(1.0);
    size.min_element().max(1.0).max(long / taps as f32)
}

/// Returns the number of levels between which lookups of kernels up to a size blend, for sides in texels.
pub fn reached_levels(size: Vec2, taps: u32) -> u32 {
    square_side(size, taps).log2().floor() as u32 + 2
}

/// Looks up the mean over the square of a level of N-buffers around a place, in texels of the picture. Squares do not begin
/// before the picture: those that would are moved.
pub fn square_mean(levels: &[Picture], level: usize, place: Vec2) -> f32 {
    let apart = spacing(level as u32) as f32;
    // The square around the place begins half its side before it.
    let corner = place - 0.5 * (1u32 << level) as f32;
    // The last value is followed by those of squares outside the picture, which are 0.
    let inside = ((levels[0].side as f32 - corner) / apart).clamp(Vec2::ZERO, Vec2::ONE);
    levels[level].sample(corner / apart + 0.5) * inside.x * inside.y
}

/// Looks up the mean over a kernel in N-buffers.
pub fn n_buffer_mean(levels: &[Picture], kernel: &Kernel, taps: u32) -> f32 {
    let side = levels[0].side as f32;
    let (kernel, share) = narrowed(kernel);
    let size = 2.0 * kernel.half * side;
    let long = size.max_element().max(1.0);
    let square = square_side(size, taps).min(side);
    let level = (square.log2().floor() as usize).min(levels.len() - 1);
    let between = (square / (1u32 << level) as f32 - 1.0).clamp(0.0, 1.0);
    let along = if size.x > size.y { Vec2::X } else { Vec2::Y } * (long - square).max(0.0);
    let center = kernel.center.clamp(Vec2::ZERO, Vec2::ONE) * side;
    let mut sum = 0.0;
    for tap in 0..taps {
        let place = center + along * ((tap as f32 + 0.5) / taps as f32 - 0.5) * spread(taps);
        let fine = square_mean(levels, level, place);
        let coarse = square_mean(levels, (level + 1).min(levels.len() - 1), place);
        // Squares cannot begin before the picture. The larger one fades out where it would, since it would find casters
        // beyond the kernel instead of the empty border.
        let half = 0.5 * (1u32 << level) as f32;
        let start = (place / half - 1.0).clamp(Vec2::ZERO, Vec2::ONE);
        sum += fine + (coarse - fine) * between * start.x * start.y;
    }
    sum / taps as f32 * share_inside(&kernel, 0.5 / side) * share
}

/// Moves the first and last of several squares to the ends of a rectangle.
fn spread(taps: u32) -> f32 {
    taps as f32 / (taps as f32 - 1.0).max(1.0)
}

/// Returns the levels of the mipmaps of a picture.
pub fn mipmaps(picture: Picture) -> Vec<Picture> {
    let mut levels = vec![picture];
    while let Some(below) = levels.last().filter(|below| below.side > 1) {
        let next = Picture::from_fn(below.side / 2, |texel| below.mean_of_four(2 * texel, 1));
        levels.push(next);
    }
    levels
}

/// Side of the texels whose bilinear mean has the variance of a box of side 1: a texel's own variance of side² / 12, and that
/// of the weights between texels, side² / 6, are 1 / 12 together. Mipmaps of the kernel's own size would blur it too far.
pub const SMOOTHED: f32 = 0.577_35;

/// Looks up the mean around a kernel in mipmaps, on a device without anisotropic filters.
pub fn mipmap_mean(levels: &[Picture], kernel: &Kernel) -> f32 {
    let side = levels[0].side as f32;
    let (kernel, share) = narrowed(kernel);
    let size = (2.0 * SMOOTHED * kernel.half * side).max_element().max(1.0);
    let level = size.log2().min((levels.len() - 1) as f32);
    let center = kernel.center.clamp(Vec2::ZERO, Vec2::ONE);
    let of = |level: usize| {
        let level = level.min(levels.len() - 1);
        levels[level].sample(center * levels[level].side as f32)
    };
    let (fine, coarse) = (of(level as usize), of(level as usize + 1));
    (fine + (coarse - fine) * level.fract()) * share_inside(&kernel, 0.5 / side) * share
}

/// Returns the summed areas of a picture: each texel holds the sum over all texels up to it.
pub fn summed_areas(mut picture: Picture) -> Picture {
    let side = picture.side;
    for index in 0..side * side {
        let (x, y) = (index % side, index / side);
        if x > 0 {
            picture.texels[index] += picture.texels[index - 1];
        }
        if x + 1 == side && y > 0 {
            for column in 0..side {
                picture.texels[y * side + column] += picture.texels[(y - 1) * side + column];
            }
        }
    }
    picture
}

/// Looks up the mean over a kernel in summed areas. It is exact, and texels outside the picture count as 0.
pub fn summed_mean(sums: &Picture, kernel: &Kernel) -> f32 {
    let side = sums.side as f32;
    let half = (kernel.half * side).max(Vec2::splat(0.5));
    let area = 4.0 * half.x * half.y;
    let center = kernel.center * side;
    let limit = Vec2::splat(side);
    let (from, to) = (
        (center - half).clamp(Vec2::ZERO, limit),
        (center + half).clamp(Vec2::ZERO, limit),
    );
    // Sums are large; their differences are small and exact, so they are taken before anything is interpolated.
    let (y_from, y_to) = (from.y.floor(), to.y.floor());
    let column = |x: f32| {
        let at = |y: f32| sums.corner(x, y);
        let whole = at(y_to) - at(y_from);
        whole + (to.y - y_to) * (at(y_to + 1.0) - at(y_to))
            - (from.y - y_from) * (at(y_from + 1.0) - at(y_from))
    };
    let (x_from, x_to) = (from.x.floor(), to.x.floor());
    let (first, last) = (column(x_from), column(x_to));
    let sum = (last - first) + (to.x - x_to) * (column(x_to + 1.0) - last)
        - (from.x - x_from) * (column(x_from + 1.0) - first);
    sum / area
}

impl Picture {
    /// Sum over all texels before a corner of the grid.
    fn corner(&self, x: f32, y: f32) -> f32 {
        if x < 1.0 || y < 1.0 {
            return 0.0;
        }
        let last = self.side as i32 - 1;
        self.at(IVec2::new((x as i32 - 1).min(last), (y as i32 - 1).min(last)))
    }
}
