//! The bind group layouts of maps, and the groups that persist.

use super::gpu_types::{MapCaster, MapLight};
use crate::render::RenderContext;
use crate::render::gpu::bind_groups::{STORAGE, bind_in_order, buffer_entry};
use crate::techniques::maps::jitter;

/// The bind group layouts of maps.
#[derive(Debug)]
pub struct MapLayouts {
    /// The layout of group 0 of casters: their matrices.
    pub casters: wgpu::BindGroupLayout,
    /// The layout of group 1 of peeled casters: the first surface.
    pub first: wgpu::BindGroupLayout,
    /// The layout of group 1 of the conversion: first and second surface.
    pub surfaces: wgpu::BindGroupLayout,
    /// The layout of group 2: the light's map at a dynamic offset, the comparison sampler, the jitter
    /// texture.
    pub map: wgpu::BindGroupLayout,
    /// The layout of group 3 of the lookup: depths and squared distances.
    pub textures: wgpu::BindGroupLayout,
    /// The layout of group 3 of a lookup that reads a picture beside the depth: depth of all casters, depth of still
    /// casters, the picture.
    pub beside: wgpu::BindGroupLayout,
}

impl MapLayouts {
    /// Creates the layouts.
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
        let size = size_of::<MapCaster>();
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
                    buffer_entry(0, ShaderStages::FRAGMENT, Uniform, true, size_of::<MapLight>()),
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
            beside: layout(
                "map with a picture beside",
                &[
                    texture(0, wgpu::TextureSampleType::Depth, TextureViewDimension::D2Array),
                    texture(1, wgpu::TextureSampleType::Depth, TextureViewDimension::D2Array),
                    texture(2, float(false), TextureViewDimension::D2Array),
                ],
            ),
        }
    }

    /// Makes group 0 of casters.
    pub fn bind_casters(&self, context: &RenderContext, buffer: &wgpu::Buffer) -> wgpu::BindGroup {
        bind_in_order(
            &context.device,
            "map casters",
            &self.casters,
            [buffer.as_entire_binding()],
        )
    }

    /// Makes group 2 of the conversion and the lookup.
    pub fn bind_map(
        &self,
        context: &RenderContext,
        maps: wgpu::BindingResource,
        compare: &wgpu::Sampler,
        jitter: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        bind_in_order(
            &context.device,
            "map",
            &self.map,
            [
                maps,
                wgpu::BindingResource::Sampler(compare),
                wgpu::BindingResource::TextureView(jitter),
            ],
        )
    }
}

/// Makes the 3D texture of [`jitter::texels`].
pub fn jitter_texture(context: &RenderContext) -> wgpu::TextureView {
    use wgpu::util::DeviceExt;
    let texture = context.device.create_texture_with_data(
        &context.queue,
        &wgpu::TextureDescriptor {
            label: Some("jitter"),
            size: wgpu::Extent3d {
                width: jitter::TILE,
                height: jitter::TILE,
                depth_or_array_layers: jitter::DEPTH,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format: wgpu::TextureFormat::Rgba8Snorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::wgt::TextureDataOrder::LayerMajor,
        &jitter::texels(),
    );
    texture.create_view(&Default::default())
}
