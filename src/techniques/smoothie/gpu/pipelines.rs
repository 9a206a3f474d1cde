//! The pipelines that draw smoothies and look them up, as descriptions for the shared cache.
//!
//! Shaders `shaders/techniques/smoothie/{edge,resolve}.wgsl`

use crate::render::Gpu;
use crate::render::frame::targets::MASK_FORMAT;
use crate::render::gpu::bind_groups::{STORAGE, buffer_entry};
use crate::render::gpu::pipeline_cache::{EVERYWHERE, LESSER, PipelineDesc, Stage};
use crate::techniques::maps::gpu::layouts::MapLayouts;
use crate::techniques::maps::gpu::pipelines::BESIDE_FORMAT;
use crate::techniques::maps::request::MapShape;
use crate::techniques::smoothie::records::{SmoothieEdge, SmoothieFace};

const EDGE: &str = "techniques/smoothie/edge.wgsl";
const RESOLVE: &str = "techniques/smoothie/resolve.wgsl";

/// The shader files of smoothies.
pub const FILES: [&str; 2] = [EDGE, RESOLVE];

/// Everything that distinguishes two pipelines of one stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Key {
    /// Draws edges and corners.
    Edges,
    /// Looks up visibility.
    Resolve {
        /// The arrangement of the faces.
        shape: MapShape,
        /// The number of cascades; 1 for other shapes.
        cascade_count: u32,
    },
}

/// The bind group layouts of smoothies. The depths and the lookup use those of maps.
#[derive(Debug)]
pub struct SmoothieLayouts {
    /// The layout of group 0 of edges: their records.
    pub edges: wgpu::BindGroupLayout,
    /// The layout of group 1 of edges: the face at a dynamic offset.
    pub face: wgpu::BindGroupLayout,
}

impl SmoothieLayouts {
    /// Creates the layouts.
    pub fn new(device: &wgpu::Device) -> Self {
        use wgpu::{BufferBindingType::Uniform, ShaderStages};
        let layout = |label, entry| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries: &[entry],
            })
        };
        let edge = size_of::<SmoothieEdge>();
        let face = size_of::<SmoothieFace>();
        Self {
            edges: layout(
                "smoothie edges",
                buffer_entry(0, ShaderStages::VERTEX, STORAGE, false, edge),
            ),
            face: layout(
                "smoothie face",
                buffer_entry(0, ShaderStages::VERTEX_FRAGMENT, Uniform, true, face),
            ),
        }
    }
}

/// Describes the pipeline of a key.
pub fn describe(gpu: &Gpu, layouts: &SmoothieLayouts, maps: &MapLayouts, key: Key) -> PipelineDesc {
    match key {
        Key::Edges => {
            let fragment = Some(Stage::new(EDGE, "fragment"));
            PipelineDesc::new("smoothies", Stage::new(EDGE, "vertex"), fragment)
                .with_groups([Some(&layouts.edges), Some(&layouts.face), Some(&maps.surfaces)])
                .with_target(BESIDE_FORMAT, Some(LESSER), wgpu::ColorWrites::ALL)
        }
        Key::Resolve { shape, cascade_count } => {
            let shared = &gpu.layouts;
            PipelineDesc::new(
                "smoothie lookup",
                EVERYWHERE,
                Some(Stage::new(RESOLVE, "fragment")),
            )
            .with_groups([
                Some(&shared.view),
                Some(&shared.receiver),
                Some(&maps.map),
                Some(&maps.beside),
            ])
            .with_constants([
                ("SHAPE", f64::from(shape as u32)),
                ("CASCADE_COUNT", f64::from(cascade_count)),
            ])
            .with_target(MASK_FORMAT, None, wgpu::ColorWrites::ALL)
        }
    }
}
