//! The pictures of each light, with the levels of their filter.

use bevy_ecs::prelude::Entity;

use super::pipelines::{Key, SliceSet};
use crate::techniques::maps::gpu::recorded::FaceRecord;
use crate::techniques::occlusion_texture::component::SliceFilter;
use crate::techniques::occlusion_texture::light_slices::LightSlices;

/// Number of texels that one pass of a sum adds up.
pub const RADIX: u32 = 8;

/// Everything that distinguishes two sets of textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexturesKey {
    /// Entity of the light.
    pub entity: Entity,
    /// Filter of the light.
    pub filter: SliceFilter,
    /// Texels along a side.
    pub side: u32,
    /// Number of pictures.
    pub faces: u32,
    /// Number of layers of each picture, four slices each.
    pub groups: u32,
    /// Whether depths are drawn, and two more sets of pictures are made from them.
    pub is_split: bool,
}

impl TexturesKey {
    /// Makes the key of a light.
    pub fn new(slices: &LightSlices) -> Self {
        Self {
            entity: slices.entity,
            filter: slices.settings.filter,
            side: slices.resolution,
            faces: slices.faces.len() as u32,
            groups: slices.settings.groups(),
            is_split: slices.settings.measures(),
        }
    }

    /// Returns the kinds of passes that fill the textures.
    pub fn kinds(&self) -> impl Iterator<Item = StepKind> + use<> {
        let is_split = self.is_split;
        let splits = [SliceSet::Coverage, SliceSet::Unions].map(StepKind::Split);
        let filters: &[StepKind] = match self.filter {
            SliceFilter::NBuffers => &[StepKind::FIRST, StepKind::DENSE, StepKind::SPARSE],
            SliceFilter::Mipmaps => &[StepKind::MIPMAP],
            SliceFilter::SummedAreas => &[StepKind::Sum],
        };
        let splits = splits.into_iter().filter(move |_| is_split);
        splits.chain(filters.iter().copied())
    }

    /// Returns the pipeline of a pass between pictures.
    pub fn step(&self, kind: StepKind) -> Key {
        let groups = self.groups;
        match kind {
            StepKind::Split(set) => Key::Split { set, groups },
            StepKind::Level { is_adjacent, halves } => Key::Level {
                is_adjacent,
                halves,
                groups,
            },
            StepKind::Sum => Key::Sum,
        }
    }

    /// Distances between the texels that each pass of a sum adds along one axis.
    pub fn sum_distances(&self) -> impl Iterator<Item = u32> + use<> {
        let side = self.side;
        std::iter::successors(Some(1), |distance| Some(distance * RADIX)).take_while(move |&d| d < side)
    }
}

/// The kind of a pass between pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepKind {
    /// A set of pictures, from the depths that were drawn.
    Split(SliceSet),
    /// The next level of N-buffers or mipmaps.
    Level {
        /// Whether its means are those of four adjacent texels of the level below.
        is_adjacent: bool,
        /// Whether it has half as many texels along a side as the level below.
        halves: bool,
    },
    /// One step of sums.
    Sum,
}

impl StepKind {
    /// The first level of N-buffers.
    pub const FIRST: Self = Self::Level {
        is_adjacent: true,
        halves: false,
    };
    /// The other dense levels of N-buffers.
    pub const DENSE: Self = Self::Level {
        is_adjacent: false,
        halves: false,
    };
    /// The sparse levels of N-buffers.
    pub const SPARSE: Self = Self::Level {
        is_adjacent: false,
        halves: true,
    };
    /// A level of mipmaps.
    pub const MIPMAP: Self = Self::Level {
        is_adjacent: true,
        halves: true,
    };

    /// Whether the level below is blended.
    pub fn blends(self) -> bool {
        matches!(
            self,
            Self::Level {
                is_adjacent: true,
                ..
            }
        )
    }
}

/// One pass between pictures: from a view of layers to views of single layers.
#[derive(Debug)]
pub struct Step {
    /// The kind of the pass.
    pub kind: StepKind,
    /// The layers that are read.
    pub below: wgpu::BindGroup,
    /// The layers that are written, one for each group of slices.
    pub targets: Vec<wgpu::TextureView>,
    /// The number that the shader gets.
    pub instance: u32,
    /// The level of N-buffers that is written; 0 for other passes, which are all needed.
    pub level: u32,
}

/// Where the surfaces of a picture's closed casters are counted: layers that a later pass overwrites.
#[derive(Debug)]
pub struct Crossings {
    /// The layers, to be written.
    pub layers: Vec<wgpu::TextureView>,
    /// The layers, to be read.
    pub below: wgpu::BindGroup,
}

/// The pictures of one light.
#[derive(Debug)]
pub struct SliceTextures {
    /// The key of this set of textures.
    pub key: TexturesKey,
    /// The layers into which each picture is drawn.
    pub drawn: Vec<Vec<wgpu::TextureView>>,
    /// Where surfaces are counted in each picture; empty unless depths are drawn.
    pub crossings: Vec<Crossings>,
    /// The passes between the drawing and the lookup, in their order.
    pub steps: Vec<Step>,
    /// The bind group 3 of the lookup.
    pub group: wgpu::BindGroup,
    /// The revision that the pictures hold.
    pub record: FaceRecord,
    pub(super) in_use: bool,
}
