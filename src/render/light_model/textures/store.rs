//! The textures of cookies and profiles. All views of a device share them.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use half::f16;
use wgpu::util::DeviceExt;

use crate::render::{Gpu, RenderContext};
use crate::scene::TextureWrap;
use crate::scene::light_model::cookie::CookieImage;
use crate::scene::light_model::profile::table::{ProfileTable, UniformTable};

/// Format of cookies. Halves hold 16-bit pictures and those that are brighter than 1, and are filtered everywhere.
const COOKIE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Format of profiles, which are loaded, not filtered.
const PROFILE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// A profile as the GPU has it.
#[derive(Debug)]
pub struct GpuProfile {
    /// The table with equal steps.
    pub table: UniformTable,
    /// The texture of the table.
    pub view: wgpu::TextureView,
}

/// The textures and samplers. A texture lives as long as a light, or anybody else, holds its picture or table.
#[derive(Debug)]
pub struct LightTextureStore {
    /// Layout of group 2: the constants of one light at a dynamic offset, flat cookie, sampler, profile, cube.
    pub layout: wgpu::BindGroupLayout,
    /// Stands for a texture that a light does not have.
    pub white: wgpu::TextureView,
    /// Stands for a cube that a light does not have.
    pub white_cube: wgpu::TextureView,
    known: Mutex<Known>,
}

#[derive(Debug, Default)]
struct Known {
    /// Cookies by the address of their picture, which the entry keeps alive.
    cookies: HashMap<usize, (Arc<CookieImage>, wgpu::TextureView)>,
    /// Profiles by the address of their table, which the entry keeps alive.
    profiles: HashMap<usize, (Arc<ProfileTable>, Arc<GpuProfile>)>,
    samplers: HashMap<[TextureWrap; 2], wgpu::Sampler>,
}

impl LightTextureStore {
    /// Makes a store without textures.
    pub fn new(gpu: &Gpu) -> Self {
        let context = &gpu.context;
        let white = [f16::ONE; 4].map(f16::to_le_bytes).concat();
        Self {
            layout: layout(&context.device),
            white: upload(context, "white", Shape::flat([1, 1]), COOKIE_FORMAT, &white),
            white_cube: upload(
                context,
                "white cube",
                Shape::cube(1, 1),
                COOKIE_FORMAT,
                &white.repeat(6),
            ),
            known: Mutex::default(),
        }
    }

    /// Returns the texture of a cookie. It is uploaded when a view first asks for it.
    pub fn cookie(&self, context: &RenderContext, image: &Arc<CookieImage>) -> wgpu::TextureView {
        let address = Arc::as_ptr(image) as usize;
        if let Some((_, view)) = self.known().cookies.get(&address) {
            return view.clone();
        }
        // Made without the lock, which other views wait for. If two views make it at once, the first one is kept.
        let made = upload_cookie(context, image);
        let mut known = self.known();
        let (_, view) = known
            .cookies
            .entry(address)
            .or_insert_with(|| (image.clone(), made));
        view.clone()
    }

    /// Returns a profile. It is uploaded when a view first asks for it.
    pub fn profile(&self, context: &RenderContext, table: &Arc<ProfileTable>) -> Arc<GpuProfile> {
        let address = Arc::as_ptr(table) as usize;
        let mut known = self.known();
        let (_, profile) = known
            .profiles
            .entry(address)
            .or_insert_with(|| (table.clone(), Arc::new(upload_profile(context, table))));
        profile.clone()
    }

    /// Returns the sampler of a kind of wrapping.
    pub fn sampler(&self, context: &RenderContext, wrap: [TextureWrap; 2]) -> wgpu::Sampler {
        let mut known = self.known();
        let sampler = known
            .samplers
            .entry(wrap)
            .or_insert_with(|| create_sampler(context, wrap));
        sampler.clone()
    }

    /// Calls `visit` with the picture of each cookie, in no order.
    pub fn for_each_cookie(&self, mut visit: impl FnMut(&CookieImage)) {
        let known = self.known();
        known.cookies.values().for_each(|(image, _)| visit(image));
    }

    /// Frees the textures whose picture or table nobody else holds.
    pub fn forget_unused(&self) {
        let mut known = self.known();
        known.cookies.retain(|_, (image, _)| Arc::strong_count(image) > 1);
        known
            .profiles
            .retain(|_, (table, _)| Arc::strong_count(table) > 1);
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        // An entry is added whole or not at all, so a panic elsewhere leaves the maps usable.
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    use crate::render::gpu::bind_groups::buffer_entry;
    use crate::render::pools::gpu_types::LightTexture;
    let stage = wgpu::ShaderStages::FRAGMENT;
    let texture = |binding, filterable, view_dimension| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: stage,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable },
            view_dimension,
            multisampled: false,
        },
        count: None,
    };
    let uniform = wgpu::BufferBindingType::Uniform;
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("light texture"),
        entries: &[
            buffer_entry(0, stage, uniform, true, size_of::<LightTexture>()),
            texture(1, true, wgpu::TextureViewDimension::D2),
            wgpu::BindGroupLayoutEntry {
                binding: 2,
                visibility: stage,
                ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                count: None,
            },
            texture(3, false, wgpu::TextureViewDimension::D2),
            texture(4, true, wgpu::TextureViewDimension::Cube),
        ],
    })
}

fn upload_cookie(context: &RenderContext, image: &CookieImage) -> wgpu::TextureView {
    let limit = context.device.limits().max_texture_dimension_2d;
    let mut shape = Shape::flat([1, 1]);
    let mut bytes = Vec::new();
    // The GPU takes all levels of a face, then those of the next one.
    for levels in image.levels(limit) {
        for texel in levels.iter().flat_map(|level| &level.texels) {
            for channel in texel.extend(1.0).to_array() {
                bytes.extend(f16::from_f32(channel).to_le_bytes());
            }
        }
        let size = levels.first().map_or([1, 1], |level| [level.width, level.height]);
        let level_count = levels.len() as u32;
        shape = if image.is_cube() {
            Shape::cube(size[0], level_count)
        } else {
            Shape {
                level_count,
                ..Shape::flat(size)
            }
        };
    }
    upload(context, image.name(), shape, COOKIE_FORMAT, &bytes)
}

fn upload_profile(context: &RenderContext, table: &ProfileTable) -> GpuProfile {
    let table = table.uniform();
    let shape = Shape::flat([table.width, table.height]);
    let bytes = bytemuck::cast_slice(&table.values);
    let view = upload(context, "profile", shape, PROFILE_FORMAT, bytes);
    GpuProfile { table, view }
}

/// The size of a texture, and how it is seen.
#[derive(Clone, Copy, Debug)]
struct Shape {
    size: [u32; 2],
    layer_count: u32,
    level_count: u32,
}

impl Shape {
    /// A flat texture of one level.
    fn flat(size: [u32; 2]) -> Self {
        Self {
            size,
            layer_count: 1,
            level_count: 1,
        }
    }

    /// The six faces of a cube.
    fn cube(side: u32, level_count: u32) -> Self {
        Self {
            size: [side; 2],
            layer_count: 6,
            level_count,
        }
    }
}

fn upload(
    context: &RenderContext,
    label: &str,
    shape: Shape,
    format: wgpu::TextureFormat,
    bytes: &[u8],
) -> wgpu::TextureView {
    let descriptor = wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width: shape.size[0],
            height: shape.size[1],
            depth_or_array_layers: shape.layer_count,
        },
        mip_level_count: shape.level_count,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let order = wgpu::wgt::TextureDataOrder::LayerMajor;
    let dimension = if shape.layer_count == 6 {
        wgpu::TextureViewDimension::Cube
    } else {
        wgpu::TextureViewDimension::D2
    };
    context
        .device
        .create_texture_with_data(&context.queue, &descriptor, order, bytes)
        .create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(dimension),
            ..Default::default()
        })
}

fn create_sampler(context: &RenderContext, wrap: [TextureWrap; 2]) -> wgpu::Sampler {
    let [u, v] = wrap.map(|wrap| match wrap {
        TextureWrap::Repeat => wgpu::AddressMode::Repeat,
        TextureWrap::Mirror => wgpu::AddressMode::MirrorRepeat,
        TextureWrap::Clamp => wgpu::AddressMode::ClampToEdge,
    });
    context.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("cookie"),
        address_mode_u: u,
        address_mode_v: v,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        anisotropy_clamp: context.anisotropy,
        ..Default::default()
    })
}
