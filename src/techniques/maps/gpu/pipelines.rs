//! Pipelines that make maps and look them up, created when a frame first needs them and kept.
//!
//! Shaders `shaders/techniques/maps/{caster,convert,resolve}.wgsl`

use std::collections::HashMap;
use std::mem::offset_of;

use super::layouts::MapLayouts;
use crate::render::frame::targets::{MASK_FORMAT, RADIANCE_FORMAT};
use crate::render::gpu::bind_groups::BindGroupLayouts;
use crate::render::pools::gpu_types::SurfaceVertex;
use crate::render::{RenderContext, RenderError, Shaders};
use crate::techniques::maps::request::MapShape;
use crate::techniques::maps::settings::{MapFilter, MapFormat, MapSurface};

/// Format of the depth into which casters are drawn.
pub const MAP_DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Returns the texture format of a map that is looked up.
pub fn texture_format(format: MapFormat) -> wgpu::TextureFormat {
    match format {
        MapFormat::Depth => MAP_DEPTH,
        MapFormat::R32Float => wgpu::TextureFormat::R32Float,
        MapFormat::Rgba8TwoBytes | MapFormat::Rgba8FourBytes => wgpu::TextureFormat::Rgba8Unorm,
    }
}

/// Everything that distinguishes two pipelines; the key of the cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Key {
    /// Draws casters.
    Caster {
        /// Whether holes are cut out.
        masked: bool,
        /// Whether the first surface is left out.
        peel: bool,
    },
    /// Converts depth to the texture that is looked up.
    Convert {
        /// Format of the result.
        format: MapFormat,
        /// Which surface of the casters it holds.
        surface: MapSurface,
        /// Whether the light is directional.
        parallel: bool,
    },
    /// Looks up visibility.
    Resolve {
        /// Number of the filter in the shader, from [`filter_constant`].
        filter: u32,
        /// Arrangement of the faces.
        shape: MapShape,
        /// Number of cascades; 1 for other shapes.
        cascade_count: u32,
        /// Format of a texel.
        format: MapFormat,
        /// Whether it writes the number of taps into the colours.
        show_taps: bool,
    },
    /// Draws the edges of the volumes that faces show.
    Frustum,
}

/// Returns the shader's number of a filter.
pub fn filter_constant(filter: MapFilter) -> u32 {
    match filter {
        MapFilter::Bilinear => 0,
        MapFilter::Brute4x4 => 1,
        MapFilter::Dithered4 => 2,
        MapFilter::Jittered { adaptive: false, .. } => 3,
        MapFilter::Soft4 { .. } => 4,
        MapFilter::Jittered { adaptive: true, .. } => 5,
    }
}

/// The pipelines of maps, cached.
#[derive(Debug)]
pub struct MapPipelines {
    /// Bind group layouts of maps.
    pub layouts: MapLayouts,
    caster: wgpu::ShaderModule,
    convert: wgpu::ShaderModule,
    resolve: wgpu::ShaderModule,
    frustum: wgpu::ShaderModule,
    caster_layouts: [wgpu::PipelineLayout; 4],
    convert_layout: wgpu::PipelineLayout,
    resolve_layout: wgpu::PipelineLayout,
    pipelines: HashMap<Key, wgpu::RenderPipeline>,
}

impl MapPipelines {
    /// Compiles the shaders; pipelines come later.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(
        context: &RenderContext,
        shaders: &Shaders,
        shared: &BindGroupLayouts,
    ) -> Result<Self, RenderError> {
        let device = &context.device;
        let layouts = MapLayouts::new(device);
        let layout = |label, groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let (casters, first, material) = (&layouts.casters, &layouts.first, &shared.material);
        Ok(Self {
            caster: shaders.module(device, "techniques/maps/caster.wgsl")?,
            convert: shaders.module(device, "techniques/maps/convert.wgsl")?,
            resolve: shaders.module(device, "techniques/maps/resolve.wgsl")?,
            frustum: shaders.module(device, "techniques/maps/frustum.wgsl")?,
            caster_layouts: [
                layout("map caster", &[Some(casters)]),
                layout("map caster, masked", &[Some(casters), None, Some(material)]),
                layout("map caster, peeled", &[Some(casters), Some(first)]),
                layout(
                    "map caster, masked and peeled",
                    &[Some(casters), Some(first), Some(material)],
                ),
            ],
            convert_layout: layout(
                "map conversion",
                &[None, Some(&layouts.surfaces), Some(&layouts.map)],
            ),
            resolve_layout: layout(
                "map lookup",
                &[
                    Some(&shared.view),
                    Some(&shared.receiver),
                    Some(&layouts.map),
                    Some(&layouts.textures),
                ],
            ),
            layouts,
            pipelines: HashMap::new(),
        })
    }

    /// Returns the pipeline, if [`MapPipelines::require`] has made it.
    pub fn get(&self, key: Key) -> Option<&wgpu::RenderPipeline> {
        self.pipelines.get(&key)
    }

    /// Makes the pipeline if it does not exist yet.
    pub fn require(&mut self, context: &RenderContext, key: Key) {
        if !self.pipelines.contains_key(&key) {
            let pipeline = match key {
                Key::Caster { masked, peel } => self.create_caster(context, masked, peel),
                Key::Convert { .. } => self.create_convert(context, key),
                Key::Resolve { .. } => self.create_resolve(context, key),
                Key::Frustum => self.create_frustum(context),
            };
            self.pipelines.insert(key, pipeline);
        }
    }

    /// Draws both sides, because any triangle blocks, whichever way it faces.
    fn create_caster(&self, context: &RenderContext, masked: bool, peel: bool) -> wgpu::RenderPipeline {
        const POSITION: &[wgpu::VertexAttribute] = &wgpu::vertex_attr_array![0 => Float32x3];
        const UV_AND_COLOR: &[wgpu::VertexAttribute] = &[
            wgpu::VertexAttribute {
                format: wgpu::VertexFormat::Float32x4,
                offset: offset_of!(SurfaceVertex, uv) as u64,
                shader_location: 3,
            },
            wgpu::VertexAttribute {
                format: wgpu::VertexFormat::Float32x4,
                offset: offset_of!(SurfaceVertex, color) as u64,
                shader_location: 4,
            },
        ];
        let buffer = |array_stride, attributes| wgpu::VertexBufferLayout {
            array_stride,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes,
        };
        let buffers = [
            buffer(12, POSITION),
            buffer(size_of::<SurfaceVertex>() as u64, UV_AND_COLOR),
        ];
        let (vertex, fragment) = match (masked, peel) {
            (false, false) => ("solid", None),
            (false, true) => ("solid", Some("peel")),
            (true, false) => ("masked_vertex", Some("masked")),
            (true, true) => ("masked_vertex", Some("masked_peel")),
        };
        context
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("map caster"),
                layout: Some(&self.caster_layouts[usize::from(masked) + 2 * usize::from(peel)]),
                vertex: wgpu::VertexState {
                    module: &self.caster,
                    entry_point: Some(vertex),
                    compilation_options: Default::default(),
                    buffers: if masked { &buffers } else { &buffers[..1] },
                },
                primitive: Default::default(),
                depth_stencil: Some(depth_state(wgpu::CompareFunction::Greater)),
                multisample: Default::default(),
                fragment: fragment.map(|entry_point| wgpu::FragmentState {
                    module: &self.caster,
                    entry_point: Some(entry_point),
                    compilation_options: Default::default(),
                    targets: &[],
                }),
                multiview_mask: None,
                cache: None,
            })
    }

    fn create_convert(&self, context: &RenderContext, key: Key) -> wgpu::RenderPipeline {
        let Key::Convert {
            format,
            surface,
            parallel,
        } = key
        else {
            unreachable!("asked for by `require`")
        };
        let is_depth = format == MapFormat::Depth;
        let depth_constants = [
            ("SURFACE", f64::from(surface as u32)),
            ("PARALLEL", f64::from(u8::from(parallel))),
        ];
        let distance_constants = [
            ("FORMAT", f64::from(format as u32)),
            ("SURFACE", f64::from(surface as u32)),
            ("PARALLEL", f64::from(u8::from(parallel))),
        ];
        let color = [Some(wgpu::ColorTargetState {
            format: texture_format(format),
            blend: None,
            write_mask: wgpu::ColorWrites::ALL,
        })];
        let (entry_point, constants, targets) = if is_depth {
            ("depth", depth_constants.as_slice(), &[] as &[_])
        } else {
            (
                "squared_distance",
                distance_constants.as_slice(),
                color.as_slice(),
            )
        };
        self.full_screen(
            context,
            "map conversion",
            &self.convert_layout,
            is_depth.then(|| depth_state(wgpu::CompareFunction::Always)),
            wgpu::FragmentState {
                module: &self.convert,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants,
                    ..Default::default()
                },
                targets,
            },
        )
    }

    fn create_resolve(&self, context: &RenderContext, key: Key) -> wgpu::RenderPipeline {
        let Key::Resolve {
            filter,
            shape,
            cascade_count,
            format,
            show_taps,
        } = key
        else {
            unreachable!("asked for by `require`")
        };
        let constants = [
            ("FILTER", f64::from(filter)),
            ("SHAPE", f64::from(shape as u32)),
            ("CASCADE_COUNT", f64::from(cascade_count)),
            ("FORMAT", f64::from(format as u32)),
            ("SHOW_TAPS", f64::from(u8::from(show_taps))),
        ];
        self.full_screen(
            context,
            "map lookup",
            &self.resolve_layout,
            None,
            wgpu::FragmentState {
                module: &self.resolve,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &constants,
                    ..Default::default()
                },
                targets: &[Some(wgpu::ColorTargetState {
                    format: MASK_FORMAT,
                    blend: None,
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            },
        )
    }

    fn create_frustum(&self, context: &RenderContext) -> wgpu::RenderPipeline {
        context
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("map frustum"),
                layout: Some(&self.caster_layouts[0]),
                vertex: wgpu::VertexState {
                    module: &self.frustum,
                    entry_point: Some("edge"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState {
                    topology: wgpu::PrimitiveTopology::LineList,
                    ..Default::default()
                },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: context.depth_stencil_format(),
                    depth_write_enabled: Some(false),
                    depth_compare: Some(wgpu::CompareFunction::Always),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &self.frustum,
                    entry_point: Some("line"),
                    compilation_options: Default::default(),
                    targets: &[Some(wgpu::ColorTargetState {
                        format: RADIANCE_FORMAT,
                        blend: None,
                        write_mask: wgpu::ColorWrites::COLOR,
                    })],
                }),
                multiview_mask: None,
                cache: None,
            })
    }

    fn full_screen(
        &self,
        context: &RenderContext,
        label: &str,
        layout: &wgpu::PipelineLayout,
        depth_stencil: Option<wgpu::DepthStencilState>,
        fragment: wgpu::FragmentState,
    ) -> wgpu::RenderPipeline {
        context
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(label),
                layout: Some(layout),
                vertex: wgpu::VertexState {
                    module: fragment.module,
                    entry_point: Some("vertex"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil,
                multisample: Default::default(),
                fragment: Some(fragment),
                multiview_mask: None,
                cache: None,
            })
    }
}

fn depth_state(compare: wgpu::CompareFunction) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: MAP_DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(compare),
        stencil: Default::default(),
        bias: Default::default(),
    }
}
