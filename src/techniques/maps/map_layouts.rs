//! The bind group layouts of maps.

use crate::render::bind_groups::{STORAGE, buffer_entry};
use crate::render::gpu_types;

/// The bind group layouts of maps.
#[derive(Debug)]
pub struct MapLayouts {
    /// Group 0 of casters: their matrices.
    pub casters: wgpu::BindGroupLayout,
    /// Group 1 of casters that are peeled: the first surface.
    pub first: wgpu::BindGroupLayout,
    /// Group 1 of the conversion: first and second surface.
    pub surfaces: wgpu::BindGroupLayout,
    /// Group 2: the light's map at a dynamic offset, the comparison, the jitter.
    pub map: wgpu::BindGroupLayout,
    /// Group 3 of the lookup: depths and squared distances.
    pub textures: wgpu::BindGroupLayout,
}

impl MapLayouts {
    /// Builds them.
    pub fn new(device: &wgpu::Device) -> Self {
        use wgpu::{BufferBindingType::Uniform, ShaderStages, TextureViewDimension};
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let texture = |binding, sample_type, view_dimension| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type,
                view_dimension,
                multisampled: false,
            },
            count: None,
        };
        let depth = |binding| texture(binding, wgpu::TextureSampleType::Depth, TextureViewDimension::D2);
        let float = |filterable| wgpu::TextureSampleType::Float { filterable };
        let size = size_of::<gpu_types::MapCaster>();
        Self {
            casters: layout(
                "map casters",
                &[buffer_entry(0, ShaderStages::VERTEX, STORAGE, false, size)],
            ),
            first: layout("first surface", &[depth(0)]),
            surfaces: layout("surfaces", &[depth(0), depth(1)]),
            map: layout(
                "map",
                &[
                    buffer_entry(
                        0,
                        ShaderStages::FRAGMENT,
                        Uniform,
                        true,
                        size_of::<gpu_types::MapLight>(),
                    ),
                    wgpu::BindGroupLayoutEntry {
                        binding: 1,
                        visibility: ShaderStages::FRAGMENT,
                        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison),
                        count: None,
                    },
                    texture(2, float(true), TextureViewDimension::D3),
                ],
            ),
            textures: layout(
                "map textures",
                &[
                    texture(0, wgpu::TextureSampleType::Depth, TextureViewDimension::D2Array),
                    texture(1, float(false), TextureViewDimension::D2Array),
                ],
            ),
        }
    }
}
