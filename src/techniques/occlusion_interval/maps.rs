//! Occlusion interval maps on the CPU: pages of texels, and where the triangles of the scene are on them.

use std::ops::Range;

use glam::{UVec2, Vec2};

use super::intervals::{Interval, Intervals, PER_PAIR, Window, blended};
use crate::scene::LightPath;

/// Most layers of the texture arrays: those that WebGPU guarantees. All pairs of all pages are layers.
pub const MAX_LAYERS: usize = 256;

/// Most texels along a side of a page. Every WebGPU device holds twice as many.
pub const MAX_SIZE: u32 = 4096;

/// Most bytes of all textures of one light's maps, 4 GiB. Bakes of more are refused, and so are files that claim more.
pub const MAX_BYTES: u64 = 4 << 30;

/// The maps of one light: the intervals of every texel of a static scene.
#[derive(Clone, Debug, PartialEq)]
pub struct IntervalMaps {
    /// Hash of everything that the maps depend on: the scene, the path and the settings of the bake.
    pub key: u64,
    /// The path of the light for which the maps were made.
    pub path: LightPath,
    /// Density of the texels on surfaces, texels per metre.
    pub texels_per_metre: f32,
    /// Texels along each side of a page.
    pub size: u32,
    /// The pages, those with most pairs first.
    pub pages: Vec<Page>,
    /// Everything that stood still in the scene, receivers and casters alike.
    pub surfaces: Vec<BakedSurface>,
    /// Three corners for each triangle of the surfaces that receive shadows; [`Corner::NOWHERE`] for those on no page.
    pub corners: Vec<Corner>,
    /// Numbers of the bake.
    pub statistics: BakeStatistics,
}

/// One page of texels. Every texel has the same number of pairs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Page {
    /// The pairs of textures, at least one. A texel fills the channels of each pair before those of the next.
    pub pairs: Vec<Pair>,
}

/// A pair of textures, four bytes a texel each, rows from the top. Channels hold the `rise` and `fall` of four intervals.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pair {
    /// First steps in which the light is seen.
    pub rise: Vec<u8>,
    /// Last steps in which the light is seen.
    pub fall: Vec<u8>,
}

/// A surface of the scene: one submesh of one object.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedSurface {
    /// Name of the mesh, used in messages.
    pub mesh: String,
    /// Hash of the positions of the triangles' corners ([`surface_hash`](super::surface_hash)).
    pub hash: u64,
    /// Columns of the object's transform: three axes and the origin.
    pub world_from_local: [f32; 12],
    /// Whether the maps hold what the backs of the triangles see, too.
    pub is_two_sided: bool,
    /// Whether the surface blocked the light for which the maps were made.
    pub casts: bool,
    /// Range of [`IntervalMaps::corners`]. Empty for a surface that shows no shadows.
    pub corners: Range<u32>,
}

/// A corner of a triangle on a page.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Corner {
    /// Index of the page. It is the same for the three corners of a triangle.
    pub page: u32,
    /// Place on the page, texels from its upper left corner.
    pub texel: Vec2,
}

impl Corner {
    /// The corners of a triangle that is on no page, because it has no area or cannot be laid flat. Charts are padded, so no
    /// other corner is here. Such a triangle shows no shadow.
    pub const NOWHERE: Self = Self {
        page: 0,
        texel: Vec2::ZERO,
    };
}

/// Numbers of a bake.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BakeStatistics {
    /// Texels that hold a surface or its rim.
    pub texels: u64,
    /// Rays that were cast. Steps for which a texel faces away from the light take none.
    pub rays: u64,
    /// Time in which rays were cast, seconds. Threads that cast at the same time count once.
    pub seconds: f64,
    /// Most intervals of a texel.
    pub most_intervals: u32,
    /// Charts that are coarser than asked for, because they would not fit onto a page.
    pub coarser_charts: u32,
}

impl Page {
    /// Makes a page of texels without intervals.
    pub fn dark(size: u32, pairs: usize) -> Self {
        let bytes = size as usize * size as usize * PER_PAIR;
        let pair = Pair {
            rise: vec![Interval::NONE.rise; bytes],
            fall: vec![Interval::NONE.fall; bytes],
        };
        Self {
            pairs: vec![pair; pairs],
        }
    }

    /// Writes the intervals of a texel, given by its index. Those for which there is no pair are left out.
    pub fn write(&mut self, texel: usize, intervals: &[Interval]) {
        for (pair, group) in self.pairs.iter_mut().zip(intervals.chunks(PER_PAIR)) {
            for (channel, interval) in group.iter().enumerate() {
                pair.rise[texel * PER_PAIR + channel] = interval.rise;
                pair.fall[texel * PER_PAIR + channel] = interval.fall;
            }
        }
    }

    /// Reads the intervals of a texel, given by its index.
    pub fn read(&self, texel: usize) -> Intervals {
        let channels = texel * PER_PAIR..(texel + 1) * PER_PAIR;
        let of_pair = |pair: &Pair| -> Intervals {
            let rise = pair.rise.get(channels.clone()).unwrap_or_default();
            let fall = pair.fall.get(channels.clone()).unwrap_or_default();
            let pairs = rise.iter().zip(fall);
            pairs.map(|(&rise, &fall)| Interval { rise, fall }).collect()
        };
        let all = self.pairs.iter().flat_map(of_pair);
        all.filter(|interval| interval.rise <= interval.fall).collect()
    }
}

impl IntervalMaps {
    /// The window of time of a light on this path.
    pub fn window(&self, time: f32, width: f32) -> Window {
        Window::new(self.path.time(time), width, self.path.is_closed())
    }

    /// Returns the number of layers of the texture arrays: all pairs of all pages.
    pub fn layer_count(&self) -> usize {
        self.pages.iter().map(|page| page.pairs.len()).sum()
    }

    /// Most pairs of a page.
    pub fn pair_count(&self) -> usize {
        self.pages.iter().map(|page| page.pairs.len()).max().unwrap_or(0)
    }

    /// Size of the textures, bytes.
    pub fn bytes(&self) -> u64 {
        bytes_of(self.size, self.layer_count())
    }

    /// Visibility at a place of a page. CPU twin of the shader.
    pub fn visibility(&self, page: u32, texel: Vec2, window: &Window) -> f32 {
        let Some(page) = self.pages.get(page as usize) else {
            return 1.0;
        };
        let corner = texel - 0.5;
        let between = corner - corner.floor();
        let last = self.size.saturating_sub(1) as f32;
        let read = |x: f32, y: f32| {
            let at = (corner.floor() + Vec2::new(x, y))
                .clamp(Vec2::ZERO, Vec2::splat(last))
                .as_uvec2();
            page.read(self.index_of(at))
        };
        let texels = [read(0.0, 0.0), read(1.0, 0.0), read(0.0, 1.0), read(1.0, 1.0)];
        blended(
            texels.each_ref().map(|texel| texel.as_slice()),
            between.to_array(),
            window,
        )
    }

    /// The index of a texel on its page.
    pub fn index_of(&self, texel: UVec2) -> usize {
        texel.y as usize * self.size as usize + texel.x as usize
    }
}

/// Size of the textures of some layers, bytes.
pub fn bytes_of(size: u32, layers: usize) -> u64 {
    u64::from(size)
        .pow(2)
        .saturating_mul((2 * PER_PAIR * layers) as u64)
}

/// Number of pairs that a number of intervals takes, at least one.
#[cfg(any(feature = "reference", test))]
pub fn pairs_for(intervals: usize) -> usize {
    intervals.div_ceil(PER_PAIR).max(1)
}

#[cfg(test)]
mod tests {
    use super::super::intervals::intervals_of;
    use super::*;

    #[test]
    fn texels_keep_their_intervals_in_as_many_pairs_as_they_need() {
        for (count, pairs) in [(0, 1), (1, 1), (4, 1), (5, 2), (12, 3), (128, 32)] {
            assert_eq!(pairs_for(count), pairs);
            let intervals = intervals_of(|step| step % 2 == 0 && step / 2 < count);
            assert_eq!(intervals.len(), count);
            let mut page = Page::dark(2, pairs);
            page.write(3, &intervals);
            assert_eq!(page.read(3), intervals);
            assert!(page.read(2).is_empty(), "neighbours stay dark");
        }
    }

    #[test]
    fn too_few_pairs_lose_intervals() {
        let intervals = intervals_of(|step| step % 20 == 0);
        let mut page = Page::dark(1, 2);
        page.write(0, &intervals);
        assert_eq!(page.read(0).len(), 8, "of {}", intervals.len());
    }
}
