//! The pipelines that draw receivers into the mask, and their bind groups.
//!
//! Shader `shaders/techniques/occlusion_interval/resolve.wgsl`

use super::gpu_types::{IntervalVertex, Window};
use crate::render::Gpu;
use crate::render::frame::targets::MASK_FORMAT;
use crate::render::gpu::bind_groups::buffer_entry;
use crate::render::gpu::pipeline_cache::{PipelineDesc, Stage};
use crate::render::nodes::pipelines::front_face;

/// The shader file.
pub const FILE: &str = "techniques/occlusion_interval/resolve.wgsl";

/// Everything that distinguishes two pipelines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Key {
    /// True if view and object together mirror, so that front faces wind clockwise.
    pub mirrored: bool,
    /// True if back faces are culled.
    pub culled: bool,
}

const VERTEX_BUFFERS: [wgpu::VertexBufferLayout<'static>; 2] = [
    wgpu::VertexBufferLayout {
        array_stride: size_of::<IntervalVertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x2, 2 => Uint32],
    },
    wgpu::VertexBufferLayout {
        array_stride: 4,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![3 => Uint32],
    },
];

/// The bind group layout of the maps.
#[derive(Debug)]
pub struct IntervalLayouts {
    /// The layout of group 1: the window at a dynamic offset, and the intervals.
    pub maps: wgpu::BindGroupLayout,
}

impl IntervalLayouts {
    /// Creates the layout.
    pub fn new(device: &wgpu::Device) -> Self {
        use wgpu::{BufferBindingType::Uniform, ShaderStages};
        let texture = wgpu::BindGroupLayoutEntry {
            binding: 1,
            visibility: ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Uint,
                view_dimension: wgpu::TextureViewDimension::D2Array,
                multisampled: false,
            },
            count: None,
        };
        Self {
            maps: device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("interval maps"),
                entries: &[
                    buffer_entry(0, ShaderStages::FRAGMENT, Uniform, true, size_of::<Window>()),
                    texture,
                ],
            }),
        }
    }
}

/// Describes the pipeline of a key.
pub fn describe(gpu: &Gpu, layouts: &IntervalLayouts, key: Key) -> PipelineDesc {
    let desc = PipelineDesc::new(
        "interval lookup",
        Stage::new(FILE, "vertex"),
        Some(Stage::new(FILE, "fragment")),
    )
    .with_groups([Some(&gpu.layouts.view), Some(&layouts.maps)])
    .with_depth(
        gpu.context.depth_stencil_format(),
        false,
        wgpu::CompareFunction::Equal,
        Default::default(),
    )
    .with_target(MASK_FORMAT, None, wgpu::ColorWrites::ALL);
    PipelineDesc {
        buffers: &VERTEX_BUFFERS,
        primitive: wgpu::PrimitiveState {
            front_face: front_face(key.mirrored),
            cull_mode: key.culled.then_some(wgpu::Face::Back),
            ..Default::default()
        },
        ..desc
    }
}
