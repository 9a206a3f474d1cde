//! The pictures of each light, with the levels of their filter.

use bevy_ecs::prelude::Entity;
use smallvec::{SmallVec, smallvec};

use super::pipelines::{COVERAGE_FORMAT, Key, PICTURE_FORMAT, SliceSet};
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

    /// Returns the format of the pictures into which casters are drawn.
    pub fn drawn_format(&self) -> wgpu::TextureFormat {
        match self.filter {
            SliceFilter::NBuffers if !self.is_split => COVERAGE_FORMAT,
            _ => PICTURE_FORMAT,
        }
    }

    /// Returns the format of a set of pictures that is made from depths.
    pub fn split_format(&self, set: SliceSet) -> wgpu::TextureFormat {
        match (self.filter, set) {
            (SliceFilter::NBuffers, SliceSet::Unions) => COVERAGE_FORMAT,
            _ => PICTURE_FORMAT,
        }
    }

    /// Returns the pipelines of the passes that fill the textures.
    pub fn steps(&self) -> SmallVec<[Key; 8]> {
        let mut keys = SmallVec::new();
        let mut formats: SmallVec<[_; 3]> = smallvec![self.drawn_format()];
        if self.is_split {
            for set in [SliceSet::Coverage, SliceSet::Unions] {
                let format = self.split_format(set);
                keys.push(self.step(StepKind::Split(set), format));
                formats.push(format);
            }
        }
        match self.filter {
            SliceFilter::NBuffers => {
                let dense = [StepKind::FIRST, StepKind::DENSE];
                keys.extend(
                    formats
                        .iter()
                        .flat_map(|&format| dense.map(|kind| self.step(kind, format))),
                );
                keys.push(self.step(StepKind::SPARSE, PICTURE_FORMAT));
            }
            SliceFilter::Mipmaps => keys.push(self.step(StepKind::MIPMAP, PICTURE_FORMAT)),
            SliceFilter::SummedAreas => keys.push(Key::Sum),
        }
        keys
    }

    /// Returns the pipeline of a pass into pictures of a format.
    pub fn step(&self, kind: StepKind, format: wgpu::TextureFormat) -> Key {
        let groups = self.groups;
        match kind {
            StepKind::Split(set) => Key::Split { set, format, groups },
            StepKind::Level { is_adjacent, halves } => Key::Level {
                is_adjacent,
                halves,
                format,
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
    /// The pipeline of the pass.
    pub pipeline: Key,
    /// The layers that are read.
    pub below: wgpu::BindGroup,
    /// The layers that are written, one for each group of slices.
    pub targets: Vec<wgpu::TextureView>,
    /// The number that the shader gets.
    pub instance: u32,
    /// The level of N-buffers that is written; 0 for other passes, which are all needed.
    pub level: u32,
}

/// The layers of one picture, or of one of its levels.
#[derive(Clone, Debug)]
pub struct PictureLayers {
    /// The layers, to be written.
    pub written: Vec<wgpu::TextureView>,
    /// The layers, to be read.
    pub read: wgpu::BindGroup,
}

/// The pictures of one light.
#[derive(Debug)]
pub struct SliceTextures {
    /// The key of this set of textures.
    pub key: TexturesKey,
    /// The layers into which each picture is drawn.
    pub drawn: Vec<Vec<wgpu::TextureView>>,
    /// Where the surfaces of each picture's closed casters are counted: layers that a later pass overwrites. Empty unless
    /// depths are drawn.
    pub crossings: Vec<PictureLayers>,
    /// The passes between the drawing and the lookup, in their order.
    pub steps: Vec<Step>,
    /// The bind group 3 of the lookup.
    pub group: wgpu::BindGroup,
    /// The revision that the pictures hold.
    pub record: FaceRecord,
    pub(super) in_use: bool,
}
