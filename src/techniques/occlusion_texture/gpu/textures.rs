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
            SliceFilter::NBuffers => &[StepKind::Level, StepKind::HalvedLevel],
            SliceFilter::Mipmaps => &[StepKind::HalvedLevel],
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
            StepKind::Level => Key::Level {
                halves: false,
                groups,
            },
            StepKind::HalvedLevel => Key::Level { halves: true, groups },
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
    /// The next level of N-buffers, with as many texels as the level below.
    Level,
    /// The next level of N-buffers or mipmaps, with half as many texels along a side as the level below.
    HalvedLevel,
    /// One step of sums.
    Sum,
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

/// The pictures of one light.
#[derive(Debug)]
pub struct SliceTextures {
    /// The key of this set of textures.
    pub key: TexturesKey,
    /// The layers into which each picture is drawn.
    pub drawn: Vec<Vec<wgpu::TextureView>>,
    /// The passes between the drawing and the lookup, in their order.
    pub steps: Vec<Step>,
    /// The bind group 3 of the lookup.
    pub group: wgpu::BindGroup,
    /// The revision that the pictures hold.
    pub record: FaceRecord,
    pub(super) in_use: bool,
}
