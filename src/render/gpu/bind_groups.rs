//! Every bind group layout: 0 view, 1 light, 2 material (or a technique's casters), 3 the pass's own. And what binds them.

use std::num::NonZeroU64;

use crate::render::pools::gpu_types;

/// The layouts shared by passes; built once.
#[derive(Debug)]
pub struct BindGroupLayouts {
    /// Group 0: view and objects.
    pub view: wgpu::BindGroupLayout,
    /// Group 1: one light, at a dynamic offset of [`Strided`](super::strided::Strided).
    pub light: wgpu::BindGroupLayout,
    /// Group 2 of drawn surfaces.
    pub material: wgpu::BindGroupLayout,
    /// Group 3 of passes that fetch positions themselves: those of one mesh.
    pub positions: wgpu::BindGroupLayout,
    /// Group 1 of passes that resolve a mask: depth and plane of what each pixel shows.
    pub receiver: wgpu::BindGroupLayout,
    /// Group 3 of passes that read a light's visibility mask.
    pub mask: wgpu::BindGroupLayout,
    /// Group 3 of passes that read the depth of a frame or of its front layer.
    pub depth: wgpu::BindGroupLayout,
    /// Group 3 of the pass that takes a host's depth.
    pub host: wgpu::BindGroupLayout,
    /// Group 3 of the tonemap.
    pub tonemap: wgpu::BindGroupLayout,
}

/// A buffer entry of a layout.
pub fn buffer_entry(
    binding: u32,
    visibility: wgpu::ShaderStages,
    ty: wgpu::BufferBindingType,
    has_dynamic_offset: bool,
    size: usize,
) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset,
            min_binding_size: NonZeroU64::new(size as u64),
        },
        count: None,
    }
}

fn texture_entry(binding: u32, filterable: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    }
}

fn depth_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Depth,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    }
}

/// A bind group of resources with the bindings 0, 1, 2 and so on.
pub fn bind_in_order<'a>(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(label),
        layout,
        entries: &entries,
    })
}

/// Read-only storage.
pub const STORAGE: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: true };

impl BindGroupLayouts {
    /// Builds them.
    pub fn new(device: &wgpu::Device) -> Self {
        use wgpu::{BufferBindingType::Uniform, ShaderStages};
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let mut material = vec![buffer_entry(
            0,
            ShaderStages::FRAGMENT,
            Uniform,
            false,
            size_of::<gpu_types::Material>(),
        )];
        for slot in 0..5 {
            material.push(texture_entry(1 + 2 * slot, true));
            material.push(wgpu::BindGroupLayoutEntry {
                binding: 2 + 2 * slot,
                visibility: ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                count: None,
            });
        }
        Self {
            view: layout(
                "view",
                &[
                    buffer_entry(
                        0,
                        ShaderStages::VERTEX_FRAGMENT,
                        Uniform,
                        false,
                        size_of::<gpu_types::View>(),
                    ),
                    buffer_entry(
                        1,
                        ShaderStages::VERTEX,
                        STORAGE,
                        false,
                        size_of::<gpu_types::Object>(),
                    ),
                ],
            ),
            light: layout(
                "light",
                &[buffer_entry(
                    0,
                    ShaderStages::FRAGMENT,
                    Uniform,
                    true,
                    size_of::<gpu_types::Light>(),
                )],
            ),
            material: layout("material", &material),
            positions: layout(
                "positions",
                &[buffer_entry(0, ShaderStages::VERTEX, STORAGE, false, 12)],
            ),
            receiver: layout(
                "receiver",
                &[
                    texture_entry(0, false),
                    wgpu::BindGroupLayoutEntry {
                        binding: 1,
                        visibility: ShaderStages::FRAGMENT,
                        ty: wgpu::BindingType::Texture {
                            sample_type: wgpu::TextureSampleType::Uint,
                            view_dimension: wgpu::TextureViewDimension::D2,
                            multisampled: false,
                        },
                        count: None,
                    },
                ],
            ),
            mask: layout("mask", &[texture_entry(0, false)]),
            depth: layout("depth", &[depth_entry(0)]),
            host: layout(
                "host depth",
                &[
                    depth_entry(0),
                    buffer_entry(
                        1,
                        ShaderStages::FRAGMENT,
                        Uniform,
                        false,
                        size_of::<gpu_types::HostDepth>(),
                    ),
                ],
            ),
            tonemap: layout(
                "tonemap",
                &[
                    texture_entry(0, false),
                    buffer_entry(1, ShaderStages::FRAGMENT, Uniform, false, 16),
                ],
            ),
        }
    }
}
