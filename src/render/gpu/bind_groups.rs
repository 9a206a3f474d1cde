//! Every bind group layout, and a function that binds resources in order. Group 0 is the view, 1 the light, 2
//! the material (or a technique's casters), and 3 belongs to the pass.

use std::num::NonZeroU64;

use crate::render::pools::gpu_types;
use crate::render::pools::textures::TEXTURE_COUNT;

/// The bind group layouts that passes share. They are built once.
#[derive(Debug)]
pub struct BindGroupLayouts {
    /// The layout of group 0: view and objects.
    pub view: wgpu::BindGroupLayout,
    /// The layout of group 1: one light, at a dynamic offset of [`Strided`](super::strided::Strided).
    pub light: wgpu::BindGroupLayout,
    /// The layout of group 2 of drawn surfaces: one material.
    pub material: wgpu::BindGroupLayout,
    /// The layout of group 3 of passes that fetch positions themselves: the positions of one mesh.
    pub positions: wgpu::BindGroupLayout,
    /// The layout of group 1 of passes that resolve a mask: depth and plane of the surface that each pixel
    /// shows.
    pub receiver: wgpu::BindGroupLayout,
    /// The layout of group 3 of passes that read a light's visibility mask.
    pub mask: wgpu::BindGroupLayout,
    /// The layout of group 3 of passes that read a light's visibility mask and the mask of its functions.
    pub masks: wgpu::BindGroupLayout,
    /// The layout of group 3 of passes that read the depth of a frame or of its front layer.
    pub depth: wgpu::BindGroupLayout,
    /// The layout of group 3 of the pass that reads a host's depth.
    pub host: wgpu::BindGroupLayout,
    /// The layout of group 3 of the tonemap: radiance and exposure.
    pub tonemap: wgpu::BindGroupLayout,
}

/// Makes the layout entry of a buffer. `size` is the smallest size that may be bound, bytes.
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

/// Makes a bind group of resources with the bindings 0, 1, 2 and so on.
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

/// The binding type of read-only storage.
pub const STORAGE: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: true };

impl BindGroupLayouts {
    /// Builds all layouts.
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
        for slot in 0..TEXTURE_COUNT as u32 {
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
            masks: layout("masks", &[texture_entry(0, false), texture_entry(1, false)]),
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
