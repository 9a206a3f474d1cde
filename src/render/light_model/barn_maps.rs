//! Barn maps: textures of what passes the barn doors of lights, kept while their shapes stay the same.
//!
//! Shader  `barn_map` of `shaders/passes/light_model.wgsl`
//! Groups  2 light model
//! Writes  the map of a light
//! Order   while the frame is prepared, in the frame in which the shape changed
//!
//! Source: Pellacini & Vidimce 2004, "Cinematic Lighting", GPU Gems ch. 10, §10.4.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::render::gpu::bind_groups::bind_in_order;
use crate::render::gpu::pipeline_cache::{EVERYWHERE, PipelineDesc, Stage};
use crate::render::{Gpu, RenderError};
use crate::scene::{BarnMap, LightShape};

/// Format of a map. Every device draws to it and filters it.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// What all views share.
#[derive(Debug)]
pub struct BarnMapParts {
    /// Layout of group 3: map and sampler.
    pub layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    /// Number of maps drawn so far.
    pub made: AtomicUsize,
}

impl BarnMapParts {
    /// Makes the layout and the sampler.
    pub fn new(gpu: &Gpu) -> Self {
        let device = &gpu.context.device;
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        Self {
            layout: device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("barn map"),
                entries: &[entry(0, texture), entry(1, sampler)],
            }),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("barn map"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            made: AtomicUsize::new(0),
        }
    }
}

/// The shape and the size of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarnMapKey {
    /// The shape that the map holds.
    pub shape: LightShape,
    /// Its settings.
    pub map: BarnMap,
}

#[derive(Debug)]
struct Entry {
    key: BarnMapKey,
    view: wgpu::TextureView,
    group: wgpu::BindGroup,
    is_used: bool,
}

/// The maps of one view. Lights with one shape share a map.
#[derive(Debug)]
pub struct BarnMaps {
    parts: Arc<BarnMapParts>,
    pipeline: Option<wgpu::RenderPipeline>,
    entries: Vec<Entry>,
}

impl BarnMaps {
    /// Has no maps yet.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            parts: gpu.part(BarnMapParts::new),
            pipeline: None,
            entries: Vec::new(),
        }
    }

    /// Layout of the group of a map.
    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.parts.layout
    }

    /// The bind group of a map that [`BarnMaps::require`] was called for in this frame.
    pub fn group(&self, key: &BarnMapKey) -> Option<&wgpu::BindGroup> {
        let entry = self.entries.iter().find(|entry| entry.key == *key)?;
        Some(&entry.group)
    }

    /// Makes the maps of a frame's lights that are not there, and drops those that no light has. Each light has a key
    /// and the offset of its constants in `models`.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn require(
        &mut self,
        gpu: &Gpu,
        lights: impl Iterator<Item = (BarnMapKey, u32)> + Clone,
        models: (&wgpu::BindGroupLayout, &wgpu::BindGroup),
    ) -> Result<(), RenderError> {
        for entry in &mut self.entries {
            entry.is_used = lights.clone().any(|(key, _)| key == entry.key);
        }
        let mut encoder = None;
        for (key, offset) in lights {
            if self.group(&key).is_some() {
                continue;
            }
            let pipeline = match &self.pipeline {
                Some(pipeline) => pipeline.clone(),
                None => self.pipeline.insert(gpu.pipeline(describe(models.0))?).clone(),
            };
            let encoder =
                encoder.get_or_insert_with(|| gpu.context.device.create_command_encoder(&Default::default()));
            let entry = self.place(gpu, key);
            draw(encoder, &entry.view, &pipeline, (models.1, offset));
            self.parts.made.fetch_add(1, Ordering::Relaxed);
        }
        self.entries.retain(|entry| entry.is_used);
        if let Some(encoder) = encoder {
            gpu.context.queue.submit([encoder.finish()]);
        }
        Ok(())
    }

    /// The entry of a new map. It takes over the texture of a map that no light has any longer, so a shape that changes
    /// in each frame makes no textures.
    fn place(&mut self, gpu: &Gpu, key: BarnMapKey) -> &Entry {
        let free = |entry: &Entry| !entry.is_used && entry.key.map == key.map;
        let at = match self.entries.iter().position(free) {
            Some(at) => at,
            None => {
                let entry = make(gpu, &self.parts, key);
                self.entries.push(entry);
                self.entries.len() - 1
            }
        };
        let entry = &mut self.entries[at];
        (entry.key, entry.is_used) = (key, true);
        entry
    }
}

fn describe(models: &wgpu::BindGroupLayout) -> PipelineDesc {
    let fragment = Stage::new("passes/light_model.wgsl", "barn_map");
    PipelineDesc::new("barn map", EVERYWHERE, Some(fragment))
        .with_groups([None, None, Some(models)])
        .with_target(FORMAT, None, wgpu::ColorWrites::ALL)
}

fn make(gpu: &Gpu, parts: &BarnMapParts, key: BarnMapKey) -> Entry {
    let device = &gpu.context.device;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("barn map"),
        size: wgpu::Extent3d {
            width: key.map.resolution,
            height: key.map.resolution,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let view = texture.create_view(&Default::default());
    let resources = [
        wgpu::BindingResource::TextureView(&view),
        wgpu::BindingResource::Sampler(&parts.sampler),
    ];
    Entry {
        key,
        group: bind_in_order(device, "barn map", &parts.layout, resources),
        view,
        is_used: true,
    }
}

fn draw(
    encoder: &mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    pipeline: &wgpu::RenderPipeline,
    (models, offset): (&wgpu::BindGroup, u32),
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("barn map"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: wgpu::StoreOp::Store,
            },
        })],
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(2, models, &[offset]);
    pass.draw(0..3, 0..1);
}
