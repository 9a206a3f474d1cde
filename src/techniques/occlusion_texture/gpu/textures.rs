//! The pictures of each light, with the levels of their filter.

use bevy_ecs::prelude::Entity;

use super::pipelines::{PICTURE_FORMAT, SUM_FORMAT, SliceLayouts};
use crate::render::RenderContext;
use crate::render::gpu::bind_groups::bind_in_order;
use crate::techniques::maps::gpu::recorded::FaceRecord;
use crate::techniques::occlusion_texture::component::SliceFilter;
use crate::techniques::occlusion_texture::filter::level_count;
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
        }
    }

    /// Distances between the texels that each pass of a sum adds along one axis.
    pub fn sum_distances(&self) -> impl Iterator<Item = u32> + use<> {
        let side = self.side;
        std::iter::successors(Some(1), |distance| Some(distance * RADIX)).take_while(move |&d| d < side)
    }
}

/// One pass of a filter: from a view of layers to views of single layers.
#[derive(Debug)]
pub struct Step {
    /// The layers that are read.
    pub below: wgpu::BindGroup,
    /// The layers that are written, one for each group of slices.
    pub targets: Vec<wgpu::TextureView>,
    /// The number that the shader gets.
    pub instance: u32,
    /// The level of N-buffers that is written; 0 for other filters, whose steps are all needed.
    pub level: u32,
}

/// The pictures of one light.
#[derive(Debug)]
pub struct SliceTextures {
    /// The key of this set of textures.
    pub key: TexturesKey,
    /// The layers into which each picture is drawn.
    pub drawn: Vec<Vec<wgpu::TextureView>>,
    /// The passes of the filter, in their order.
    pub steps: Vec<Step>,
    /// The bind group 3 of the lookup.
    pub group: wgpu::BindGroup,
    /// The revision that the pictures hold.
    pub record: FaceRecord,
    in_use: bool,
}

/// Makes the textures of a light.
struct Maker<'a> {
    context: &'a RenderContext,
    layouts: &'a SliceLayouts,
    key: TexturesKey,
}

impl Maker<'_> {
    fn texture(&self, label: &str, format: wgpu::TextureFormat, layers: u32, mips: u32) -> wgpu::Texture {
        self.context.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d {
                width: self.key.side,
                height: self.key.side,
                depth_or_array_layers: layers,
            },
            mip_level_count: mips,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    fn view(&self, texture: &wgpu::Texture, first: u32, count: Option<u32>, mip: u32) -> wgpu::TextureView {
        texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(if count.is_some() {
                wgpu::TextureViewDimension::D2Array
            } else {
                wgpu::TextureViewDimension::D2
            }),
            base_array_layer: first,
            array_layer_count: Some(count.unwrap_or(1)),
            base_mip_level: mip,
            mip_level_count: Some(1),
            ..Default::default()
        })
    }

    fn layers(&self, texture: &wgpu::Texture, first: u32, mip: u32) -> Vec<wgpu::TextureView> {
        (first..first + self.key.groups)
            .map(|layer| self.view(texture, layer, None, mip))
            .collect()
    }

    fn below(&self, texture: &wgpu::Texture, first: u32, count: u32, mip: u32) -> wgpu::BindGroup {
        let view = self.view(texture, first, Some(count), mip);
        let views = [wgpu::BindingResource::TextureView(&view)];
        bind_in_order(
            &self.context.device,
            "slice level below",
            &self.layouts.below,
            views,
        )
    }

    /// The bind group of the lookup, with a sampler if the filter needs one.
    fn lookup(&self, texture: &wgpu::Texture) -> wgpu::BindGroup {
        let device = &self.context.device;
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let filter = match self.key.filter {
            SliceFilter::SummedAreas => wgpu::FilterMode::Nearest,
            SliceFilter::NBuffers | SliceFilter::Mipmaps => wgpu::FilterMode::Linear,
        };
        let is_mipmapped = self.key.filter == SliceFilter::Mipmaps;
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("slice pictures"),
            mag_filter: filter,
            min_filter: filter,
            mipmap_filter: if is_mipmapped {
                wgpu::MipmapFilterMode::Linear
            } else {
                wgpu::MipmapFilterMode::Nearest
            },
            anisotropy_clamp: if is_mipmapped { self.context.anisotropy } else { 1 },
            ..Default::default()
        });
        let resources = [
            wgpu::BindingResource::TextureView(&view),
            wgpu::BindingResource::Sampler(&sampler),
        ];
        let layout = self.layouts.pictures(self.key.filter);
        bind_in_order(device, "slice pictures", layout, resources)
    }

    /// Makes the textures. Each filter has its own arrangement of levels.
    fn make(&self) -> SliceTextures {
        let (drawn, steps, group) = match self.key.filter {
            SliceFilter::NBuffers => self.n_buffers(),
            SliceFilter::Mipmaps => self.mipmaps(),
            SliceFilter::SummedAreas => self.summed_areas(),
        };
        SliceTextures {
            key: self.key,
            drawn,
            steps,
            group,
            record: FaceRecord::default(),
            in_use: true,
        }
    }

    /// Levels are layers: those of a picture follow each other, and those of its groups within a level.
    fn n_buffers(&self) -> (Vec<Vec<wgpu::TextureView>>, Vec<Step>, wgpu::BindGroup) {
        let TexturesKey {
            side, faces, groups, ..
        } = self.key;
        let levels = level_count(side);
        let texture = self.texture("slice N-buffers", PICTURE_FORMAT, faces * groups * levels, 1);
        let first = |face: u32, level: u32| (face * levels + level) * groups;
        let (mut drawn, mut steps) = (Vec::new(), Vec::new());
        for face in 0..faces {
            drawn.push(self.layers(&texture, first(face, 0), 0));
            for level in 1..levels {
                steps.push(Step {
                    below: self.below(&texture, first(face, level - 1), groups, 0),
                    targets: self.layers(&texture, first(face, level), 0),
                    instance: 1 << (level - 1),
                    level,
                });
            }
        }
        (drawn, steps, self.lookup(&texture))
    }

    fn mipmaps(&self) -> (Vec<Vec<wgpu::TextureView>>, Vec<Step>, wgpu::BindGroup) {
        let TexturesKey {
            side, faces, groups, ..
        } = self.key;
        let levels = level_count(side);
        let texture = self.texture("slice mipmaps", PICTURE_FORMAT, faces * groups, levels);
        let (mut drawn, mut steps) = (Vec::new(), Vec::new());
        for face in 0..faces {
            drawn.push(self.layers(&texture, face * groups, 0));
            for level in 1..levels {
                steps.push(Step {
                    below: self.below(&texture, face * groups, groups, level - 1),
                    targets: self.layers(&texture, face * groups, level),
                    instance: 0,
                    level: 0,
                });
            }
        }
        (drawn, steps, self.lookup(&texture))
    }

    /// Two textures take turns. The number of passes is even, so the last one writes the second.
    fn summed_areas(&self) -> (Vec<Vec<wgpu::TextureView>>, Vec<Step>, wgpu::BindGroup) {
        let TexturesKey { faces, groups, .. } = self.key;
        let layers = faces * groups;
        let pictures = self.texture("slice pictures", PICTURE_FORMAT, layers, 1);
        let sums =
            ["slice sums", "slice sums, in turn"].map(|label| self.texture(label, SUM_FORMAT, layers, 1));
        let drawn = (0..faces)
            .map(|face| self.layers(&pictures, face * groups, 0))
            .collect();
        let mut steps = Vec::new();
        let mut from = &pictures;
        let mut turn = 0;
        for is_down in [0, 1] {
            for distance in self.key.sum_distances() {
                let below = self.below(from, 0, layers, 0);
                for layer in 0..layers {
                    steps.push(Step {
                        below: below.clone(),
                        targets: vec![self.view(&sums[turn], layer, None, 0)],
                        instance: distance | is_down << 16 | layer << 17,
                        level: 0,
                    });
                }
                from = &sums[turn];
                turn = 1 - turn;
            }
        }
        (drawn, steps, self.lookup(from))
    }
}

/// The pictures of all lights.
#[derive(Debug, Default)]
pub struct TexturePool {
    all: Vec<SliceTextures>,
}

impl TexturePool {
    /// Begins to record which textures are in use.
    pub fn begin(&mut self) {
        self.all.iter_mut().for_each(|textures| textures.in_use = false);
    }

    /// Frees textures that were not requested since [`TexturePool::begin`].
    pub fn end(&mut self) {
        self.all.retain(|textures| textures.in_use);
    }

    /// Returns the textures of a key, if they were requested.
    pub fn get(&self, key: &TexturesKey) -> Option<&SliceTextures> {
        self.all.iter().find(|textures| textures.key == *key)
    }

    /// Keeps the textures of a key, if there are any.
    pub fn keep(&mut self, key: &TexturesKey) {
        for textures in self.all.iter_mut().filter(|textures| textures.key == *key) {
            textures.in_use = true;
        }
    }

    /// Makes the textures of a key, if there are none.
    pub fn require(&mut self, context: &RenderContext, layouts: &SliceLayouts, key: TexturesKey) {
        if self.get(&key).is_some() {
            self.keep(&key);
        } else {
            let maker = Maker {
                context,
                layouts,
                key,
            };
            self.all.push(maker.make());
        }
    }
}
