//! The pipelines of blurred grounds, as descriptions for the shared cache.
//!
//! Shaders `shaders/techniques/perspective_map/{color,blur,ground}.wgsl`

use super::gpu_types::Grounds;
use crate::render::frame::targets::MASK_FORMAT;
use crate::render::gpu::bind_groups::{STORAGE, buffer_entry};
use crate::render::gpu::pipeline_cache::{EVERYWHERE_WITH_INSTANCE, PipelineDesc, Stage};
use crate::render::{Gpu, SURFACE_BUFFERS};
use crate::techniques::maps::gpu::layouts::MapLayouts;
use crate::techniques::maps::gpu::pipelines::{MAP_DEPTH, MASKED_BUFFERS, SOLID_BUFFERS};

const COLOR: &str = "techniques/perspective_map/color.wgsl";
const BLUR: &str = "techniques/perspective_map/blur.wgsl";
const GROUND: &str = "techniques/perspective_map/ground.wgsl";

/// The shader files of blurred grounds.
pub const FILES: [&str; 3] = [COLOR, BLUR, GROUND];

/// The format of the pictures of grounds: a channel for each ground.
pub const PICTURE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Everything that distinguishes two pipelines of one stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Key {
    /// Draws the colours of casters, or of grounds that cast nothing.
    Color {
        /// True if holes are cut out of the surface.
        masked: bool,
        /// True for what has drawn its depth.
        casts: bool,
    },
    /// Blurs along one axis of the grounds, 0 or 1.
    Blur {
        /// The axis.
        axis: u32,
    },
    /// Writes the visibility of grounds into the mask.
    Ground,
}

/// The bind group layouts of blurred grounds, and their sampler.
#[derive(Debug)]
pub struct GroundLayouts {
    /// The layout of group 1 of colours and of the lookup: the channel of each caster or object.
    pub channels: wgpu::BindGroupLayout,
    /// The layout of group 1 of the blur: the grounds.
    pub grounds: wgpu::BindGroupLayout,
    /// The layout of group 3 of the blur and of the lookup: a picture and its sampler.
    pub picture: wgpu::BindGroupLayout,
    /// Interpolates between texels.
    pub bilinear: wgpu::Sampler,
}

impl GroundLayouts {
    /// Creates the layouts.
    pub fn new(device: &wgpu::Device) -> Self {
        use wgpu::{BufferBindingType::Uniform, ShaderStages};
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let picture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        Self {
            channels: layout(
                "ground channels",
                &[buffer_entry(0, ShaderStages::VERTEX, STORAGE, false, 4)],
            ),
            grounds: layout(
                "grounds",
                &[buffer_entry(
                    0,
                    ShaderStages::FRAGMENT,
                    Uniform,
                    false,
                    size_of::<Grounds>(),
                )],
            ),
            picture: layout("ground picture", &[entry(0, picture), entry(1, sampler)]),
            bilinear: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("ground picture"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
        }
    }
}

/// Keeps the maximum of each channel.
const MAXIMUM: wgpu::BlendState = {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Max,
    };
    wgpu::BlendState {
        color: component,
        alpha: component,
    }
};

/// Describes the pipeline of a key.
pub fn describe(gpu: &Gpu, layouts: &GroundLayouts, maps: &MapLayouts, key: Key) -> PipelineDesc {
    let shared = &gpu.layouts;
    match key {
        Key::Color { masked, casts } => {
            let (vertex, fragment, buffers) = if masked {
                ("masked_vertex", "masked", MASKED_BUFFERS)
            } else {
                ("solid_vertex", "solid", SOLID_BUFFERS)
            };
            // A ground that casts nothing is lit where no caster is nearer, and darkens no other ground.
            let (compare, blend) = if casts {
                (wgpu::CompareFunction::Equal, None)
            } else {
                (wgpu::CompareFunction::GreaterEqual, Some(MAXIMUM))
            };
            let desc = PipelineDesc::new(
                "ground color",
                Stage::new(COLOR, vertex),
                Some(Stage::new(COLOR, fragment)),
            )
            .with_groups([
                Some(&maps.casters),
                Some(&layouts.channels),
                masked.then_some(&shared.material),
            ])
            .with_depth(MAP_DEPTH, false, compare, Default::default())
            .with_target(PICTURE_FORMAT, blend, wgpu::ColorWrites::ALL);
            PipelineDesc { buffers, ..desc }
        }
        Key::Blur { axis } => PipelineDesc::new(
            "ground blur",
            EVERYWHERE_WITH_INSTANCE,
            Some(Stage::new(BLUR, "fragment")),
        )
        .with_groups([
            None,
            Some(&layouts.grounds),
            Some(&maps.map),
            Some(&layouts.picture),
        ])
        .with_constants([("AXIS", f64::from(axis))])
        .with_target(PICTURE_FORMAT, None, wgpu::ColorWrites::ALL),
        Key::Ground => {
            let desc = PipelineDesc::new(
                "ground lookup",
                Stage::new(GROUND, "vertex"),
                Some(Stage::new(GROUND, "fragment")),
            )
            .with_groups([
                Some(&shared.view),
                Some(&layouts.channels),
                Some(&maps.map),
                Some(&layouts.picture),
            ])
            .with_depth(
                gpu.context.depth_stencil_format(),
                false,
                wgpu::CompareFunction::Equal,
                Default::default(),
            )
            .with_target(MASK_FORMAT, None, wgpu::ColorWrites::ALL);
            PipelineDesc {
                buffers: &SURFACE_BUFFERS,
                ..desc
            }
        }
    }
}
