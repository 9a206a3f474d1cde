//! The pipelines that draw, filter and look up slices, as descriptions for the shared cache.
//!
//! Shaders `shaders/techniques/occlusion_texture/{caster,filter,resolve}.wgsl`

use crate::render::Gpu;
use crate::render::frame::targets::MASK_FORMAT;
use crate::render::gpu::bind_groups::{STORAGE, buffer_entry};
use crate::render::gpu::pipeline_cache::{ADD, EVERYWHERE, EVERYWHERE_WITH_INSTANCE, PipelineDesc, Stage};
use crate::techniques::maps::gpu::gpu_types::MapCaster;
use crate::techniques::maps::gpu::pipelines::{MASKED_BUFFERS, SOLID_BUFFERS};
use crate::techniques::occlusion_texture::component::{SliceCombination, SliceFilter};
use crate::techniques::occlusion_texture::records::{OcclusionFace, OcclusionLight};

/// The format of pictures. Every WebGPU device can blend and filter it, and can draw four of it at once: together they take
/// 32 bytes a sample, the least limit that a device may have.
pub const PICTURE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The format of the dense levels of N-buffers of coverage and unions: half the bytes, and a software driver samples it faster.
/// It is rounded three times, by half of 1/255 at most. The sparse levels have [`PICTURE_FORMAT`], because rounding would add up
/// over them. So do coverage and depths of overlaps: depths are divided by coverage, however small it is.
pub const COVERAGE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// The format of sums, which are whole numbers up to the square of the resolution.
pub const SUM_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// The contents of a set of pictures that is made from depths of casters, one picture for each slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SliceSet {
    /// Coverage of each slice.
    Coverage,
    /// Coverage of each slice and all slices before it together.
    Unions,
}

/// Everything that distinguishes two pipelines of one stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Key {
    /// Draws casters into the channels of their slices.
    Caster {
        /// True if holes are cut out of the casters.
        masked: bool,
        /// True if casters fill the next slice too.
        closes: bool,
        /// The faces that are left out: the backs or the fronts of closed casters.
        culled: Option<wgpu::Face>,
        /// True if depths are drawn instead of what casters cover.
        depths: bool,
        /// Format of the picture.
        format: wgpu::TextureFormat,
        /// Number of colour targets.
        groups: u32,
    },
    /// Counts the surfaces of closed casters between the light and the top of each slice, fronts less backs.
    Crossings {
        /// Number of colour targets.
        groups: u32,
    },
    /// Fills slices whose top lies inside of closed casters.
    Fill {
        /// Number of colour targets.
        groups: u32,
    },
    /// Makes one of the sets of pictures that are made from depths of casters.
    Split {
        /// The set that is made.
        set: SliceSet,
        /// Format of the set.
        format: wgpu::TextureFormat,
        /// Number of colour targets.
        groups: u32,
    },
    /// Makes the next level of N-buffers or mipmaps.
    Level {
        /// True if the means are those of four adjacent texels.
        is_adjacent: bool,
        /// True if the level has half as many texels along a side as the level below.
        halves: bool,
        /// Format of the level.
        format: wgpu::TextureFormat,
        /// Number of colour targets.
        groups: u32,
    },
    /// Makes one step of the sums.
    Sum,
    /// Looks up visibility.
    Resolve {
        /// The filter.
        filter: SliceFilter,
        /// The combination of slices.
        combine: SliceCombination,
        /// Number of slices.
        slices: u32,
        /// Number of pictures.
        faces: u32,
        /// True if casters fill the next slice too.
        closes: bool,
    },
}

const CASTER: &str = "techniques/occlusion_texture/caster.wgsl";
const FILTER: &str = "techniques/occlusion_texture/filter.wgsl";
const RESOLVE: &str = "techniques/occlusion_texture/resolve.wgsl";

/// The shader files of occlusion textures.
pub const FILES: [&str; 3] = [CASTER, FILTER, RESOLVE];

/// The bind group layouts of occlusion textures, and what does not differ between bind groups.
#[derive(Debug)]
pub struct SliceLayouts {
    /// The layout of group 0 of casters: their matrices.
    pub casters: wgpu::BindGroupLayout,
    /// The layout of group 1 of casters: the picture at a dynamic offset.
    pub face: wgpu::BindGroupLayout,
    /// The layout of group 0 of filters: the level below, and a sampler that takes single texels.
    pub below: wgpu::BindGroupLayout,
    /// The sampler of filters that takes single texels.
    pub single_texels: wgpu::Sampler,
    /// The layout of group 0 of filters: the level below, and a sampler that blends texels.
    pub below_blended: wgpu::BindGroupLayout,
    /// The sampler of filters that blends texels.
    pub blended_texels: wgpu::Sampler,
    /// The layout of group 2 of the lookup: the light at a dynamic offset.
    pub light: wgpu::BindGroupLayout,
    /// The layout of group 3 of the lookup in pictures that hardware filters.
    pub filtered: wgpu::BindGroupLayout,
    /// The layout of group 3 of the lookup in sums.
    pub sums: wgpu::BindGroupLayout,
}

impl SliceLayouts {
    /// Creates the layouts.
    pub fn new(device: &wgpu::Device) -> Self {
        use wgpu::{BufferBindingType::Uniform, ShaderStages};
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let texture = |binding, filterable| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable },
                view_dimension: wgpu::TextureViewDimension::D2Array,
                multisampled: false,
            },
            count: None,
        };
        use wgpu::SamplerBindingType::{Filtering, NonFiltering};
        let sampler = |kind| wgpu::BindGroupLayoutEntry {
            binding: 1,
            visibility: ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Sampler(kind),
            count: None,
        };
        let uniform = |size| buffer_entry(0, ShaderStages::FRAGMENT, Uniform, true, size);
        let caster = size_of::<MapCaster>();
        Self {
            casters: layout(
                "slice casters",
                &[buffer_entry(0, ShaderStages::VERTEX, STORAGE, false, caster)],
            ),
            face: layout("slice face", &[uniform(size_of::<OcclusionFace>())]),
            below: layout("slice level below", &[texture(0, false), sampler(NonFiltering)]),
            single_texels: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("single texels of slices"),
                ..Default::default()
            }),
            below_blended: layout("slice level below", &[texture(0, true), sampler(Filtering)]),
            blended_texels: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("blended texels of slices"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            light: layout("slice light", &[uniform(size_of::<OcclusionLight>())]),
            filtered: layout(
                "slice pictures",
                &[
                    texture(0, true),
                    sampler(Filtering),
                    texture(2, true),
                    texture(3, true),
                    texture(4, true),
                    texture(5, true),
                    texture(6, true),
                ],
            ),
            // The shader names a sampler for the other filters. One that does not filter fits any texture.
            sums: layout(
                "slice sums",
                &[
                    texture(0, false),
                    sampler(NonFiltering),
                    texture(2, false),
                    texture(3, false),
                    texture(4, false),
                    texture(5, false),
                    texture(6, false),
                ],
            ),
        }
    }

    /// Returns the layout of group 3 of the lookup.
    pub fn pictures(&self, filter: SliceFilter) -> &wgpu::BindGroupLayout {
        match filter {
            SliceFilter::NBuffers | SliceFilter::Mipmaps => &self.filtered,
            SliceFilter::SummedAreas => &self.sums,
        }
    }
}

/// Keeps the maximum, of each channel by itself.
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

/// Adds the targets of several groups of slices.
fn with_targets(
    desc: PipelineDesc,
    groups: u32,
    format: wgpu::TextureFormat,
    blend: Option<wgpu::BlendState>,
) -> PipelineDesc {
    (0..groups).fold(desc, |desc, _| {
        desc.with_target(format, blend, wgpu::ColorWrites::ALL)
    })
}

/// Describes a pass from layers of pictures to as many others.
fn step(
    layouts: &SliceLayouts,
    label: &'static str,
    entry: &'static str,
    groups: u32,
    format: wgpu::TextureFormat,
    blend: Option<wgpu::BlendState>,
) -> PipelineDesc {
    let fragment = Some(Stage::new(FILTER, entry));
    let desc = PipelineDesc::new(label, EVERYWHERE_WITH_INSTANCE, fragment)
        .with_groups([Some(&layouts.below)])
        .with_constants([("GROUPS", f64::from(groups))]);
    with_targets(desc, groups, format, blend)
}

/// Describes the pipeline of a key.
pub fn describe(gpu: &Gpu, layouts: &SliceLayouts, key: Key) -> PipelineDesc {
    match key {
        Key::Caster {
            masked,
            closes,
            culled,
            depths,
            format,
            groups,
        } => {
            let (vertex, fragment, buffers) = if masked {
                ("masked_vertex", "masked", MASKED_BUFFERS)
            } else {
                ("solid_vertex", "solid", SOLID_BUFFERS)
            };
            let fragment = Some(Stage::new(CASTER, fragment));
            let desc = PipelineDesc {
                buffers,
                primitive: wgpu::PrimitiveState {
                    cull_mode: culled,
                    ..Default::default()
                },
                ..PipelineDesc::new("slice caster", Stage::new(CASTER, vertex), fragment)
                    .with_groups([
                        Some(&layouts.casters),
                        Some(&layouts.face),
                        masked.then_some(&gpu.layouts.material),
                    ])
                    .with_constants([
                        ("CLOSE", f64::from(u8::from(closes))),
                        ("DEPTHS", f64::from(u8::from(depths))),
                    ])
            };
            with_targets(desc, groups, format, Some(MAXIMUM))
        }
        Key::Crossings { groups } => {
            let fragment = Some(Stage::new(CASTER, "crossings"));
            let desc = PipelineDesc {
                buffers: SOLID_BUFFERS,
                ..PipelineDesc::new("slice crossings", Stage::new(CASTER, "solid_vertex"), fragment)
                    .with_groups([Some(&layouts.casters), Some(&layouts.face)])
            };
            with_targets(desc, groups, PICTURE_FORMAT, Some(ADD))
        }
        Key::Fill { groups } => step(
            layouts,
            "slice fill",
            "fill",
            groups,
            PICTURE_FORMAT,
            Some(MAXIMUM),
        ),
        Key::Split { set, format, groups } => {
            let entry = match set {
                SliceSet::Coverage => "cover",
                SliceSet::Unions => "unite",
            };
            step(layouts, "slice split", entry, groups, format, None)
        }
        Key::Level {
            is_adjacent: true,
            halves,
            format,
            groups,
        } => step(layouts, "slice filter", "adjacent_level", groups, format, None)
            .with_groups([Some(&layouts.below_blended)])
            .with_constants([
                ("GROUPS", f64::from(groups)),
                ("STRIDE", if halves { 2.0 } else { 1.0 }),
            ]),
        Key::Level {
            halves,
            format,
            groups,
            ..
        } => {
            let entry = if halves { "halved_level" } else { "level" };
            step(layouts, "slice filter", entry, groups, format, None)
        }
        Key::Sum => PipelineDesc::new(
            "slice sums",
            EVERYWHERE_WITH_INSTANCE,
            Some(Stage::new(FILTER, "sum")),
        )
        .with_groups([Some(&layouts.below)])
        .with_target(SUM_FORMAT, None, wgpu::ColorWrites::ALL),
        Key::Resolve {
            filter,
            combine,
            slices,
            faces,
            closes,
        } => {
            let shared = &gpu.layouts;
            PipelineDesc::new("slice lookup", EVERYWHERE, Some(Stage::new(RESOLVE, "fragment")))
                .with_groups([
                    Some(&shared.view),
                    Some(&shared.receiver),
                    Some(&layouts.light),
                    Some(layouts.pictures(filter)),
                ])
                .with_constants([
                    ("FILTER", f64::from(filter as u32)),
                    ("COMBINE", f64::from(combine as u32)),
                    ("SLICES", f64::from(slices)),
                    ("FACES", f64::from(faces)),
                    ("CLOSE", f64::from(closes)),
                ])
                .with_target(MASK_FORMAT, None, wgpu::ColorWrites::ALL)
        }
    }
}
