//! Makes the textures of a light, and the passes that fill them.

use super::pipelines::{PICTURE_FORMAT, SUM_FORMAT, SliceLayouts, SliceSet};
use super::textures::{PictureLayers, SliceTextures, Step, StepKind, TexturesKey};
use crate::render::RenderContext;
use crate::render::gpu::bind_groups::bind_in_order;
use crate::techniques::maps::gpu::recorded::FaceRecord;
use crate::techniques::occlusion_texture::component::SliceFilter;
use crate::techniques::occlusion_texture::filter::{DENSE_LEVEL, level_count};

/// Makes the textures of a light.
pub(super) struct Maker<'a> {
    pub context: &'a RenderContext,
    pub layouts: &'a SliceLayouts,
    pub key: TexturesKey,
}

/// One set of pictures and the passes that filter it.
struct Filtered {
    /// The first level of each picture.
    first: Vec<PictureLayers>,
    steps: Vec<Step>,
    /// The textures that are looked up: all pictures, and the sparse levels of N-buffers. Other filters have no sparse levels,
    /// and the first texture stands for them.
    result: [wgpu::Texture; 2],
}

impl Maker<'_> {
    fn texture(
        &self,
        label: &str,
        format: wgpu::TextureFormat,
        side: u32,
        layers: u32,
        mips: u32,
    ) -> wgpu::Texture {
        self.context.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d {
                width: side,
                height: side,
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

    /// The bind group of a pass that reads layers of a mip.
    fn below(
        &self,
        kind: StepKind,
        texture: &wgpu::Texture,
        [first, count]: [u32; 2],
        mip: u32,
    ) -> wgpu::BindGroup {
        let view = self.view(texture, first, Some(count), mip);
        let (layout, sampler) = if kind.blends() {
            (&self.layouts.below_blended, &self.layouts.blended_texels)
        } else {
            (&self.layouts.below, &self.layouts.single_texels)
        };
        let resources = [
            wgpu::BindingResource::TextureView(&view),
            wgpu::BindingResource::Sampler(sampler),
        ];
        bind_in_order(&self.context.device, "slice level below", layout, resources)
    }

    /// Layers of one picture in the first mip of a texture.
    fn layers_of_picture(&self, texture: &wgpu::Texture, first: u32) -> PictureLayers {
        PictureLayers {
            written: self.layers(texture, first, 0),
            read: self.below(
                StepKind::Split(SliceSet::Coverage),
                texture,
                [first, self.key.groups],
                0,
            ),
        }
    }

    /// The bind group of the lookup in coverage, unions and depths, with a sampler if the filter needs one.
    fn lookup(&self, sets: [[wgpu::Texture; 2]; 3]) -> wgpu::BindGroup {
        let device = &self.context.device;
        let views = sets.map(|textures| {
            textures.map(|texture| {
                texture.create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(wgpu::TextureViewDimension::D2Array),
                    ..Default::default()
                })
            })
        });
        let [coverage, unions, depths] = &views;
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
            wgpu::BindingResource::TextureView(&coverage[0]),
            wgpu::BindingResource::Sampler(&sampler),
            wgpu::BindingResource::TextureView(&unions[0]),
            wgpu::BindingResource::TextureView(&depths[0]),
            wgpu::BindingResource::TextureView(&coverage[1]),
            wgpu::BindingResource::TextureView(&unions[1]),
            wgpu::BindingResource::TextureView(&depths[1]),
        ];
        let layout = self.layouts.pictures(self.key.filter);
        bind_in_order(device, "slice pictures", layout, resources)
    }

    /// Makes the textures. Each filter has its own arrangement of levels.
    pub fn make(&self) -> SliceTextures {
        let TexturesKey {
            side,
            faces,
            groups,
            filter,
            is_split,
            ..
        } = self.key;
        // All sets of sums share it.
        let scratch = (filter == SliceFilter::SummedAreas)
            .then(|| self.texture("slice sums, in turn", SUM_FORMAT, side, faces * groups, 1));
        let filtered = |format| match (filter, &scratch) {
            (SliceFilter::SummedAreas, Some(scratch)) => self.summed_areas(scratch),
            (SliceFilter::Mipmaps, _) => self.mipmaps(),
            _ => self.n_buffers(format),
        };
        let coverage = filtered(match is_split {
            true => self.key.split_format(SliceSet::Coverage),
            false => self.key.drawn_format(),
        });
        let (drawn, steps, sets);
        let mut crossings = Vec::new();
        if is_split {
            let unions = filtered(self.key.split_format(SliceSet::Unions));
            let depths = filtered(self.key.drawn_format());
            crossings.clone_from(&coverage.first);
            let mut all = self.split(&depths.first, SliceSet::Coverage, coverage.first);
            all.extend(self.split(&depths.first, SliceSet::Unions, unions.first));
            all.extend([coverage.steps, unions.steps, depths.steps].into_iter().flatten());
            (drawn, steps) = (depths.first, all);
            sets = [coverage.result, unions.result, depths.result];
        } else {
            (drawn, steps) = (coverage.first, coverage.steps);
            sets = [coverage.result.clone(), coverage.result.clone(), coverage.result];
        }
        SliceTextures {
            key: self.key,
            drawn: drawn.into_iter().map(|first| first.written).collect(),
            crossings,
            steps,
            group: self.lookup(sets),
            record: FaceRecord::default(),
            in_use: true,
        }
    }

    /// The passes that make a set of pictures from depths.
    fn split(&self, depths: &[PictureLayers], set: SliceSet, targets: Vec<PictureLayers>) -> Vec<Step> {
        let step = |(depths, targets): (&PictureLayers, PictureLayers)| Step {
            pipeline: self.key.step(StepKind::Split(set), self.key.split_format(set)),
            below: depths.read.clone(),
            targets: targets.written,
            instance: 0,
            level: 0,
        };
        depths.iter().zip(targets).map(step).collect()
    }

    /// Dense levels are layers: those of a picture follow each other, and those of its groups within a level. Sparse levels are
    /// mips of another texture of half the side.
    fn n_buffers(&self, dense_format: wgpu::TextureFormat) -> Filtered {
        let TexturesKey {
            side, faces, groups, ..
        } = self.key;
        let dense_levels = DENSE_LEVEL + 1;
        let sparse_levels = level_count(side) - dense_levels;
        let layers = faces * groups;
        let dense = self.texture("slice N-buffers", dense_format, side, layers * dense_levels, 1);
        let sparse = self.texture(
            "sparse slice N-buffers",
            PICTURE_FORMAT,
            side / 2,
            layers,
            sparse_levels,
        );
        let first = |face: u32, level: u32| (face * dense_levels + level) * groups;
        let (mut firsts, mut steps) = (Vec::new(), Vec::new());
        for face in 0..faces {
            firsts.push(self.layers_of_picture(&dense, first(face, 0)));
            for level in 1..dense_levels {
                let kind = if level == 1 {
                    StepKind::FIRST
                } else {
                    StepKind::DENSE
                };
                steps.push(Step {
                    pipeline: self.key.step(kind, dense_format),
                    below: self.below(kind, &dense, [first(face, level - 1), groups], 0),
                    targets: self.layers(&dense, first(face, level), 0),
                    instance: 1 << (level - 1),
                    level,
                });
            }
            for mip in 0..sparse_levels {
                let below = match mip.checked_sub(1) {
                    Some(mip) => self.below(StepKind::SPARSE, &sparse, [face * groups, groups], mip),
                    None => self.below(StepKind::SPARSE, &dense, [first(face, DENSE_LEVEL), groups], 0),
                };
                steps.push(Step {
                    pipeline: self.key.step(StepKind::SPARSE, PICTURE_FORMAT),
                    below,
                    targets: self.layers(&sparse, face * groups, mip),
                    instance: 1 << DENSE_LEVEL,
                    level: dense_levels + mip,
                });
            }
        }
        Filtered {
            first: firsts,
            steps,
            result: [dense, sparse],
        }
    }

    fn mipmaps(&self) -> Filtered {
        let TexturesKey {
            side, faces, groups, ..
        } = self.key;
        let levels = level_count(side);
        let texture = self.texture("slice mipmaps", PICTURE_FORMAT, side, faces * groups, levels);
        let (mut firsts, mut steps) = (Vec::new(), Vec::new());
        for face in 0..faces {
            firsts.push(self.layers_of_picture(&texture, face * groups));
            for level in 1..levels {
                steps.push(Step {
                    pipeline: self.key.step(StepKind::MIPMAP, PICTURE_FORMAT),
                    below: self.below(StepKind::MIPMAP, &texture, [face * groups, groups], level - 1),
                    targets: self.layers(&texture, face * groups, level),
                    instance: 0,
                    level: 0,
                });
            }
        }
        Filtered {
            first: firsts,
            steps,
            result: [texture.clone(), texture],
        }
    }

    /// Two textures take turns. The number of passes is even, so the last one writes the second.
    fn summed_areas(&self, scratch: &wgpu::Texture) -> Filtered {
        let TexturesKey {
            side, faces, groups, ..
        } = self.key;
        let layers = faces * groups;
        let pictures = self.texture("slice pictures", PICTURE_FORMAT, side, layers, 1);
        let sums = [scratch, &self.texture("slice sums", SUM_FORMAT, side, layers, 1)];
        let first = |face| self.layers_of_picture(&pictures, face * groups);
        let mut steps = Vec::new();
        let mut from = &pictures;
        let mut turn = 0;
        for is_down in [0, 1] {
            for distance in self.key.sum_distances() {
                let below = self.below(StepKind::Sum, from, [0, layers], 0);
                for layer in 0..layers {
                    steps.push(Step {
                        pipeline: self.key.step(StepKind::Sum, SUM_FORMAT),
                        below: below.clone(),
                        targets: vec![self.view(sums[turn], layer, None, 0)],
                        instance: distance | is_down << 16 | layer << 17,
                        level: 0,
                    });
                }
                from = sums[turn];
                turn = 1 - turn;
            }
        }
        Filtered {
            result: [from.clone(), from.clone()],
            first: (0..faces).map(first).collect(),
            steps,
        }
    }
}
