//! The pipelines that make and read maps, as descriptions for the shared cache.
//!
//! Shaders `shaders/techniques/maps/{caster,convert,resolve}.wgsl`

use std::mem::offset_of;

use super::layouts::MapLayouts;
use crate::render::Gpu;
use crate::render::frame::targets::{MASK_FORMAT, RADIANCE_FORMAT};
use crate::render::gpu::pipeline_cache::{EVERYWHERE, EVERYWHERE_WITH_INSTANCE, PipelineDesc, Stage};
use crate::render::pools::gpu_types::SurfaceVertex;
use crate::techniques::maps::request::MapShape;
use crate::techniques::maps::settings::{MapFilter, MapFormat, MapSurface};

/// The format of the depth into which casters are drawn.
pub const MAP_DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The format of pictures beside the depth. Every WebGPU device can blend it.
pub const BESIDE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg16Float;

/// Returns the texture format of a map that is looked up.
pub fn texture_format(format: MapFormat) -> wgpu::TextureFormat {
    match format {
        MapFormat::Depth => MAP_DEPTH,
        MapFormat::R32Float => wgpu::TextureFormat::R32Float,
        MapFormat::Rgba8TwoBytes | MapFormat::Rgba8FourBytes => wgpu::TextureFormat::Rgba8Unorm,
    }
}

const POSITION: wgpu::VertexBufferLayout = wgpu::VertexBufferLayout {
    array_stride: 12,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3],
};

const UV_AND_COLOR: wgpu::VertexBufferLayout = wgpu::VertexBufferLayout {
    array_stride: size_of::<SurfaceVertex>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &[
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
    ],
};

/// The vertex buffers of casters without holes.
pub const SOLID_BUFFERS: &[wgpu::VertexBufferLayout] = &[POSITION];

/// The vertex buffers of casters whose texture cuts holes.
pub const MASKED_BUFFERS: &[wgpu::VertexBufferLayout] = &[POSITION, UV_AND_COLOR];

/// Whether the first surface is left out when casters are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Peel {
    /// All surfaces are drawn.
    No,
    /// The first surface is left out. Depth is inverse to distance.
    Perspective,
    /// The first surface is left out. Depth is linear in distance.
    Parallel,
}

/// Everything that distinguishes two pipelines of one stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Key {
    /// Draws casters.
    Caster {
        /// True if holes are cut out of the casters.
        masked: bool,
        /// Whether the first surface is left out.
        peel: Peel,
    },
    /// Converts depth to the texture that is looked up.
    Convert {
        /// The format of the converted texture.
        format: MapFormat,
        /// The surface of the casters that the texture holds.
        surface: MapSurface,
        /// True if the light is directional.
        parallel: bool,
    },
    /// Looks up visibility.
    Resolve {
        /// The number of the filter in the shader, from [`filter_constant`].
        filter: u32,
        /// The arrangement of the faces.
        shape: MapShape,
        /// The number of cascades; 1 for other shapes.
        cascade_count: u32,
        /// The format of a texel.
        format: MapFormat,
        /// True if the lookup writes the number of taps into the colours of the mask.
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

const CASTER: &str = "techniques/maps/caster.wgsl";
const CONVERT: &str = "techniques/maps/convert.wgsl";
const RESOLVE: &str = "techniques/maps/resolve.wgsl";
const FRUSTUM: &str = "techniques/maps/frustum.wgsl";

/// The shader files of maps.
pub const FILES: [&str; 4] = [CASTER, CONVERT, RESOLVE, FRUSTUM];

/// Describes the pipeline of a key.
pub fn describe(gpu: &Gpu, layouts: &MapLayouts, key: Key) -> PipelineDesc {
    match key {
        Key::Caster { masked, peel } => describe_caster(gpu, layouts, masked, peel),
        Key::Convert {
            format,
            surface,
            parallel,
        } => describe_convert(layouts, format, surface, parallel),
        Key::Resolve {
            filter,
            shape,
            cascade_count,
            format,
            show_taps,
        } => {
            let shared = &gpu.layouts;
            PipelineDesc::new("map lookup", EVERYWHERE, Some(Stage::new(RESOLVE, "fragment")))
                .with_groups([
                    Some(&shared.view),
                    Some(&shared.receiver),
                    Some(&layouts.map),
                    Some(&layouts.textures),
                ])
                .with_constants([
                    ("FILTER", f64::from(filter)),
                    ("SHAPE", f64::from(shape as u32)),
                    ("CASCADE_COUNT", f64::from(cascade_count)),
                    ("FORMAT", f64::from(format as u32)),
                    ("SHOW_TAPS", f64::from(u8::from(show_taps))),
                ])
                .with_target(MASK_FORMAT, None, wgpu::ColorWrites::ALL)
        }
        Key::Frustum => describe_frustum(gpu, layouts),
    }
}

/// Describes the pipeline that draws casters. It draws both sides, because a triangle blocks light whichever
/// way it faces.
fn describe_caster(gpu: &Gpu, layouts: &MapLayouts, masked: bool, peel: Peel) -> PipelineDesc {
    let peels = peel != Peel::No;
    let (vertex, fragment, buffers) = match (masked, peels) {
        (false, false) => ("solid", None, SOLID_BUFFERS),
        (false, true) => ("solid", Some("peel"), SOLID_BUFFERS),
        (true, false) => ("masked_vertex", Some("masked"), MASKED_BUFFERS),
        (true, true) => ("masked_vertex", Some("masked_peel"), MASKED_BUFFERS),
    };
    let fragment = fragment.map(|entry| Stage::new(CASTER, entry));
    PipelineDesc {
        buffers,
        depth_stencil: Some(depth_state(wgpu::CompareFunction::Greater)),
        ..PipelineDesc::new("map caster", Stage::new(CASTER, vertex), fragment)
            .with_groups([
                Some(&layouts.casters),
                peels.then_some(&layouts.first),
                masked.then_some(&gpu.layouts.material),
            ])
            .with_constants([("PARALLEL", f64::from(u8::from(peel == Peel::Parallel)))])
    }
}

fn describe_convert(
    layouts: &MapLayouts,
    format: MapFormat,
    surface: MapSurface,
    parallel: bool,
) -> PipelineDesc {
    let is_depth = format == MapFormat::Depth;
    let entry = if is_depth { "depth" } else { "squared_distance" };
    let desc = PipelineDesc::new(
        "map conversion",
        EVERYWHERE_WITH_INSTANCE,
        Some(Stage::new(CONVERT, entry)),
    )
    .with_groups([None, Some(&layouts.surfaces), Some(&layouts.map)])
    .with_constants([
        ("SURFACE", f64::from(surface as u32)),
        ("PARALLEL", f64::from(u8::from(parallel))),
    ]);
    if is_depth {
        PipelineDesc {
            depth_stencil: Some(depth_state(wgpu::CompareFunction::Always)),
            ..desc
        }
    } else {
        desc.with_constants([("FORMAT", f64::from(format as u32))])
            .with_target(texture_format(format), None, wgpu::ColorWrites::ALL)
    }
}

fn describe_frustum(gpu: &Gpu, layouts: &MapLayouts) -> PipelineDesc {
    let desc = PipelineDesc::new(
        "map frustum",
        Stage::new(FRUSTUM, "edge"),
        Some(Stage::new(FRUSTUM, "line")),
    );
    PipelineDesc {
        primitive: wgpu::PrimitiveState {
            topology: wgpu::PrimitiveTopology::LineList,
            ..Default::default()
        },
        ..desc
            .with_groups([Some(&layouts.casters)])
            .with_depth(
                gpu.context.depth_stencil_format(),
                false,
                wgpu::CompareFunction::Always,
                Default::default(),
            )
            .with_target(RADIANCE_FORMAT, None, wgpu::ColorWrites::COLOR)
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
