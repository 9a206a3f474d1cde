//! Pictures of casters by rays, and their filters on the CPU.

use antumbra::insides::occlusion_textures::{
    Kernel, LightSlices, Picture, SliceFace, mipmap_mean, mipmaps, n_buffer_mean, n_buffers, split,
    summed_areas, summed_mean,
};
use antumbra::reference::{RayScene, SceneTriangle};
use antumbra::techniques::{OcclusionTexture, SliceCombination, SliceFilter};
use glam::DVec2;

/// The pictures of one face by rays through the middle of each texel.
pub fn cast_pictures(
    face: &SliceFace,
    scene: &RayScene,
    side: usize,
    settings: &OcclusionTexture,
) -> Vec<Picture> {
    let slices = &face.slices;
    let mut pictures = vec![Picture::from_fn(side, |_| 0.0); slices.count];
    let place = |ndc: DVec2, depth: f64| {
        let divisor = face.divisor.x * depth + face.divisor.y;
        let across = (ndc - face.offset) * divisor / face.scale;
        let [x, y, z] = face.axes;
        face.origin + x * across.x + y * across.y + z * depth
    };
    for index in 0..side * side {
        let texel = DVec2::new((index % side) as f64, (index / side) as f64);
        let ndc = ((texel + 0.5) / side as f64 * 2.0 - 1.0) * DVec2::new(1.0, -1.0);
        let (from, to) = (
            place(ndc, slices.top),
            place(ndc, slices.bottoms[slices.count - 1]),
        );
        let mut crossings = vec![0; slices.count];
        for triangle in scene.triangles() {
            let [a, b, c] = triangle.corners;
            let (u, v, along) = (b - a, c - a, to - from);
            let determinant = along.dot(u.cross(v));
            if determinant.abs() < 1e-12 {
                continue;
            }
            let from_a = from - a;
            let share = -from_a.dot(u.cross(v)) / determinant;
            let (s, t) = (
                from_a.dot(v.cross(along)) / determinant,
                from_a.dot(along.cross(u)) / determinant,
            );
            // Boxes are closed. Where slices count as independent, their backs are left out; else they close no leaks. The ground
            // is drawn from both sides.
            let is_back = triangle_is_closed(triangle) && determinant > 0.0;
            let is_drawn = !is_back || settings.combine == SliceCombination::Overlap;
            let closes = settings.close_leaks != 0 && !is_back;
            let inside = s >= 0.0 && t >= 0.0 && s + t <= 1.0 && is_drawn;
            if !inside || !(0.0..=1.0).contains(&share) {
                continue;
            }
            let depth = face.light_from_world(from + along * share).z;
            let top_of =
                |slice: i32| usize::try_from(slice - 1).map_or(slices.top, |before| slices.bottoms[before]);
            for (slice, picture) in pictures.iter_mut().enumerate() {
                let first = slice as i32 - i32::from(closes);
                if depth > top_of(first) && depth <= slices.bottoms[slice] {
                    let top = top_of(slice as i32);
                    let below = ((depth - top) / (slices.bottoms[slice] - top)).clamp(0.0, 1.0);
                    let value = match settings.combine {
                        SliceCombination::Overlap => 2.0 - below as f32,
                        _ => 1.0,
                    };
                    picture.texels[index] = picture.texels[index].max(value);
                }
                if triangle_is_closed(triangle) && depth <= top_of(slice as i32) {
                    crossings[slice] += if is_back { -1 } else { 1 };
                }
            }
        }
        if settings.combine == SliceCombination::Overlap {
            for (picture, _) in pictures.iter_mut().zip(&crossings).filter(|(_, sum)| **sum != 0) {
                picture.texels[index] = 2.0;
            }
        }
    }
    pictures
}

/// Whether a triangle belongs to a box and not to the ground.
fn triangle_is_closed(triangle: &SceneTriangle) -> bool {
    triangle.corners.iter().any(|corner| corner.y > 0.01)
}

/// The filtered pictures of one face: what slices cover, unions and depths.
pub enum Filtered {
    Levels([Vec<Vec<Picture>>; 3]),
    Sums([Vec<Picture>; 3]),
}

impl Filtered {
    /// Splits and filters what was drawn.
    pub fn new(drawn: &[Picture], filter: SliceFilter) -> Self {
        let sets = split(drawn);
        let levels = |of: fn(Picture) -> Vec<Picture>| {
            sets.clone()
                .map(|pictures| pictures.into_iter().map(of).collect())
        };
        match filter {
            SliceFilter::NBuffers => Self::Levels(levels(n_buffers)),
            SliceFilter::Mipmaps => Self::Levels(levels(mipmaps)),
            SliceFilter::SummedAreas => {
                Self::Sums(sets.map(|pictures| pictures.into_iter().map(summed_areas).collect()))
            }
        }
    }

    /// Mean of a picture of a set over a kernel.
    pub fn mean(&self, set: usize, slice: usize, kernel: &Kernel, slices: &LightSlices) -> f32 {
        match self {
            Self::Levels(levels) if slices.settings.filter == SliceFilter::NBuffers => {
                n_buffer_mean(&levels[set][slice], kernel, slices.taps())
            }
            Self::Levels(levels) => mipmap_mean(&levels[set][slice], kernel),
            Self::Sums(sums) => summed_mean(&sums[set][slice], kernel),
        }
    }
}
