//! Makes the textures of a light, and the passes that fill them.

use super::pipelines::{PICTURE_FORMAT, SUM_FORMAT, SliceLayouts};
use super::textures::{SliceTextures, Step, StepKind, TexturesKey};
use crate::render::RenderContext;
use crate::render::gpu::bind_groups::bind_in_order;
use crate::techniques::maps::gpu::recorded::FaceRecord;
use crate::techniques::occlusion_texture::component::SliceFilter;
use crate::techniques::occlusion_texture::filter::level_count;

/// Makes the textures of a light.
pub(super) struct Maker<'a> {
    pub context: &'a RenderContext,
    pub layouts: &'a SliceLayouts,
    pub key: TexturesKey,
}

/// One set of pictures and the passes that filter it: of single slices, or of unions of slices.
struct Filtered {
    /// The texture whose first level is drawn.
    drawn_in: wgpu::Texture,
    /// The layers of the first level of each picture.
    drawn: Vec<Vec<wgpu::TextureView>>,
    steps: Vec<Step>,
    /// The texture that is looked up.
    result: wgpu::Texture,
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
    fn lookup(&self, pictures: &wgpu::Texture, unions: &wgpu::Texture) -> wgpu::BindGroup {
        let device = &self.context.device;
        let [pictures, unions] = [pictures, unions].map(|texture| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            })
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
            wgpu::BindingResource::TextureView(&pictures),
            wgpu::BindingResource::Sampler(&sampler),
            wgpu::BindingResource::TextureView(&unions),
        ];
        let layout = self.layouts.pictures(self.key.filter);
        bind_in_order(device, "slice pictures", layout, resources)
    }

    /// Makes the textures. Each filter has its own arrangement of levels.
    pub fn make(&self) -> SliceTextures {
        let TexturesKey {
            faces,
            groups,
            filter,
            has_unions,
            ..
        } = self.key;
        let scratch = (filter == SliceFilter::SummedAreas)
            .then(|| self.texture("slice sums, in turn", SUM_FORMAT, faces * groups, 1));
        let filtered = || match (filter, &scratch) {
            (SliceFilter::SummedAreas, Some(scratch)) => self.summed_areas(scratch),
            (SliceFilter::Mipmaps, _) => self.mipmaps(),
            _ => self.n_buffers(),
        };
        let own = filtered();
        let unions = has_unions.then(filtered);
        let mut steps = Vec::new();
        for (face, targets) in unions.iter().flat_map(|unions| unions.drawn.iter().enumerate()) {
            steps.push(Step {
                kind: StepKind::Unions,
                below: self.below(&own.drawn_in, self.first_layer(face as u32), groups, 0),
                targets: targets.clone(),
                instance: 0,
                level: 0,
            });
        }
        let group = self.lookup(
            &own.result,
            unions.as_ref().map_or(&own.result, |unions| &unions.result),
        );
        steps.extend(own.steps);
        steps.extend(unions.into_iter().flat_map(|unions| unions.steps));
        SliceTextures {
            key: self.key,
            drawn: own.drawn,
            steps,
            group,
            record: FaceRecord::default(),
            in_use: true,
        }
    }

    /// First layer of a picture's first level.
    fn first_layer(&self, face: u32) -> u32 {
        let levels = match self.key.filter {
            SliceFilter::NBuffers => level_count(self.key.side),
            SliceFilter::Mipmaps | SliceFilter::SummedAreas => 1,
        };
        face * levels * self.key.groups
    }

    /// Levels are layers: those of a picture follow each other, and those of its groups within a level.
    fn n_buffers(&self) -> Filtered {
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
                    kind: StepKind::Level,
                    below: self.below(&texture, first(face, level - 1), groups, 0),
                    targets: self.layers(&texture, first(face, level), 0),
                    instance: 1 << (level - 1),
                    level,
                });
            }
        }
        Filtered {
            drawn_in: texture.clone(),
            drawn,
            steps,
            result: texture,
        }
    }

    fn mipmaps(&self) -> Filtered {
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
                    kind: StepKind::Level,
                    below: self.below(&texture, face * groups, groups, level - 1),
                    targets: self.layers(&texture, face * groups, level),
                    instance: 0,
                    level: 0,
                });
            }
        }
        Filtered {
            drawn_in: texture.clone(),
            drawn,
            steps,
            result: texture,
        }
    }

    /// Two textures take turns. The number of passes is even, so the last one writes the second.
    fn summed_areas(&self, scratch: &wgpu::Texture) -> Filtered {
        let TexturesKey { faces, groups, .. } = self.key;
        let layers = faces * groups;
        let pictures = self.texture("slice pictures", PICTURE_FORMAT, layers, 1);
        let sums = [scratch, &self.texture("slice sums", SUM_FORMAT, layers, 1)];
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
                        kind: StepKind::Level,
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
            result: from.clone(),
            drawn_in: pictures.clone(),
            drawn,
            steps,
        }
    }
}
