//! Materials and textures on the GPU.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use glam::Affine2;
use smallvec::SmallVec;
use wgpu::util::DeviceExt;

use super::gpu_types;
use crate::conventions::RADIANCE_MAX;
use crate::render::gpu::bind_groups::bind_in_order;
use crate::render::gpu::mipmaps::mip_chain;
use crate::render::gpu::slots::Slots;
use crate::render::{Gpu, RenderContext};
use crate::scene::material::TextureWrap;
use crate::scene::{AlphaMode, Material, Texture, TextureSlot};

/// A texture that a host has on the device. It takes the place of a material's own base colour texture.
#[derive(Clone, Debug)]
pub struct HostTexture {
    /// The view of a 2D texture, whose format can be filtered.
    pub view: wgpu::TextureView,
    /// The sampler; it does not compare.
    pub sampler: wgpu::Sampler,
    /// Which set of texture coordinates is used: 0 or 1.
    pub uv_set: u32,
    /// Transform of the texture coordinates, applied before sampling.
    pub uv_transform: Affine2,
}

/// A material that is ready to be bound.
#[derive(Debug)]
pub struct GpuMaterial {
    /// The bind group 2 of drawn surfaces.
    pub bind_group: wgpu::BindGroup,
    /// Keeps the material alive, so that no other material can have its address.
    _source: Arc<Material>,
}

/// The largest scale of a normal texture. At a greater scale its normals would lie in the surface to within a
/// thousandth.
const STEEPEST: f32 = 1e3;

/// The encoding in which a texture's texels are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Encoding {
    Srgb,
    Linear,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct SamplerKey {
    wrap: [TextureWrap; 2],
    linear_magnify: bool,
    linear_minify: bool,
}

/// The materials that views hold, and their textures and samplers.
#[derive(Debug)]
pub struct SharedMaterials {
    white: wgpu::TextureView,
    known: Mutex<Known>,
}

#[derive(Debug, Default)]
struct Known {
    /// The materials by their addresses. Each entry keeps its material alive.
    materials: HashMap<usize, Weak<GpuMaterial>>,
    /// The base colour textures that a host has given materials, by the materials' addresses. The weak
    /// pointer keeps the address from being used again.
    hosted: HashMap<usize, (Weak<Material>, HostTexture)>,
    textures: HashMap<(usize, Encoding), (Arc<Texture>, wgpu::TextureView)>,
    samplers: HashMap<SamplerKey, wgpu::Sampler>,
}

impl SharedMaterials {
    /// Makes a store without materials.
    pub fn new(context: &RenderContext) -> Self {
        let white = context.device.create_texture_with_data(
            &context.queue,
            &texture_descriptor("white", 1, 1, 1, wgpu::TextureFormat::Rgba8Unorm),
            wgpu::wgt::TextureDataOrder::LayerMajor,
            &[255; 4],
        );
        Self {
            white: white.create_view(&Default::default()),
            known: Mutex::default(),
        }
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes a texture of the host the base colour texture of a material. Returns `false`, and changes nothing,
    /// if the material is on the device already. The host must then use another material.
    pub fn host(&self, material: &Arc<Material>, texture: HostTexture) -> bool {
        let mut known = self.known();
        let address = Arc::as_ptr(material) as usize;
        if known
            .materials
            .get(&address)
            .is_some_and(|known| known.strong_count() > 0)
        {
            return false;
        }
        known.hosted.insert(address, (Arc::downgrade(material), texture));
        true
    }

    fn get(&self, gpu: &Gpu, material: &Arc<Material>) -> Arc<GpuMaterial> {
        let address = Arc::as_ptr(material) as usize;
        let find = |known: &Known| known.materials.get(&address).and_then(Weak::upgrade);
        let missing = {
            let known = self.known();
            if let Some(found) = find(&known) {
                return found;
            }
            known.missing(material)
        };
        // Textures are made without the lock: while threads make mipmaps, this one may run another view's system, which
        // asks for materials, too.
        let made = missing.into_iter().map(|(texture, encoding)| {
            let view = upload_texture(&gpu.context, texture, encoding);
            ((Arc::as_ptr(texture) as usize, encoding), (texture.clone(), view))
        });
        let made: SmallVec<[_; 5]> = made.collect();
        let mut known = self.known();
        for (key, texture) in made {
            known.textures.entry(key).or_insert(texture);
        }
        if let Some(found) = find(&known) {
            return found;
        }
        let made = Arc::new(known.upload(&gpu.context, &gpu.layouts.material, &self.white, material));
        known.materials.insert(address, Arc::downgrade(&made));
        made
    }

    /// Removes the materials and textures that no view holds.
    fn forget_unused(&self) {
        let mut known = self.known();
        known.materials.retain(|_, material| material.strong_count() > 0);
        known
            .hosted
            .retain(|_, (material, _)| material.strong_count() > 0);
        // No material uses a texture that only this map holds.
        known
            .textures
            .retain(|_, (texture, _)| Arc::strong_count(texture) > 1);
    }
}

/// The materials that one view uses, by index.
#[derive(Debug, Default)]
pub struct MaterialPool {
    /// The materials by their addresses. Each entry keeps its material alive.
    slots: Slots<usize, Arc<GpuMaterial>>,
}

impl MaterialPool {
    /// The material at `index`, if it is in use.
    pub fn get(&self, index: u32) -> Option<&GpuMaterial> {
        self.slots.get(index).map(Arc::as_ref)
    }

    /// Begins a new count of the materials in use.
    pub fn begin(&mut self) {
        self.slots.begin();
    }

    /// Frees the materials that were not requested since [`MaterialPool::begin`].
    pub fn end(&mut self, gpu: &Gpu) {
        self.slots.end();
        gpu.materials.forget_unused();
    }

    /// Returns the index of a material. The material is uploaded if no view has it yet.
    pub fn acquire(&mut self, gpu: &Gpu, material: &Arc<Material>) -> u32 {
        let address = Arc::as_ptr(material) as usize;
        if let Some(index) = self.slots.acquire(address, |_| true) {
            return index;
        }
        self.slots.insert(address, gpu.materials.get(gpu, material))
    }
}

/// The textures of a material, and how each is read.
fn slots(material: &Material) -> [(&Option<TextureSlot>, Encoding); 5] {
    [
        (&material.base_color_texture, Encoding::Srgb),
        (&material.metallic_roughness_texture, Encoding::Linear),
        (&material.normal_texture, Encoding::Linear),
        (&material.occlusion_texture, Encoding::Linear),
        (&material.emissive_texture, Encoding::Srgb),
    ]
}

/// The texture of a slot, if it can be shown.
fn whole_texture(slot: &Option<TextureSlot>) -> Option<&Arc<Texture>> {
    slot.as_ref().map(|slot| &slot.texture).filter(|t| is_whole(t))
}

impl Known {
    /// Returns the textures of a material that are not on the device.
    fn missing<'a>(&self, material: &'a Material) -> SmallVec<[(&'a Arc<Texture>, Encoding); 5]> {
        let textures = slots(material)
            .into_iter()
            .filter_map(|(slot, encoding)| Some((whole_texture(slot)?, encoding)));
        textures
            .filter(|(texture, encoding)| {
                !self
                    .textures
                    .contains_key(&(Arc::as_ptr(texture) as usize, *encoding))
            })
            .collect()
    }

    fn upload(
        &mut self,
        context: &RenderContext,
        layout: &wgpu::BindGroupLayout,
        white: &wgpu::TextureView,
        material: &Arc<Material>,
    ) -> GpuMaterial {
        let hosted = self.hosted.get(&(Arc::as_ptr(material) as usize));
        let hosted = hosted.map(|(_, texture)| texture.clone());
        let mut constants = constants(material);
        if let Some(texture) = &hosted {
            constants.base_color_slot = present_slot(texture.uv_set, texture.uv_transform);
        }
        let buffer = context
            .device
            .create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(&material.name),
                contents: bytemuck::bytes_of(&constants),
                usage: wgpu::BufferUsages::UNIFORM,
            });
        let slots = slots(material);
        let mut views: Vec<_> = slots
            .iter()
            .map(|(slot, encoding)| self.view(slot, *encoding).unwrap_or_else(|| white.clone()))
            .collect();
        let mut samplers: Vec<_> = slots
            .iter()
            .map(|(slot, _)| self.sampler(context, slot.as_ref()))
            .collect();
        if let Some(texture) = hosted {
            (views[0], samplers[0]) = (texture.view, texture.sampler);
        }
        let textures = views.iter().zip(&samplers).flat_map(|(view, sampler)| {
            [
                wgpu::BindingResource::TextureView(view),
                wgpu::BindingResource::Sampler(sampler),
            ]
        });
        let resources = std::iter::once(buffer.as_entire_binding()).chain(textures);
        GpuMaterial {
            bind_group: bind_in_order(&context.device, &material.name, layout, resources),
            _source: material.clone(),
        }
    }

    /// Returns a texture that is on the device already.
    fn view(&self, slot: &Option<TextureSlot>, encoding: Encoding) -> Option<wgpu::TextureView> {
        let address = Arc::as_ptr(whole_texture(slot)?) as usize;
        let (_, view) = self.textures.get(&(address, encoding))?;
        Some(view.clone())
    }

    fn sampler(&mut self, context: &RenderContext, slot: Option<&TextureSlot>) -> wgpu::Sampler {
        let key = slot.map_or(
            SamplerKey {
                wrap: [TextureWrap::Repeat; 2],
                linear_magnify: true,
                linear_minify: true,
            },
            |slot| SamplerKey {
                wrap: slot.texture.wrap,
                linear_magnify: slot.texture.linear_magnify,
                linear_minify: slot.texture.linear_minify,
            },
        );
        self.samplers
            .entry(key)
            .or_insert_with(|| create_sampler(context, key))
            .clone()
    }
}

fn is_whole(texture: &Texture) -> bool {
    texture.width > 0
        && texture.height > 0
        && texture.rgba8.len() as u128 == 4 * u128::from(texture.width) * u128::from(texture.height)
}

fn create_sampler(context: &RenderContext, key: SamplerKey) -> wgpu::Sampler {
    let address = |wrap| match wrap {
        TextureWrap::Repeat => wgpu::AddressMode::Repeat,
        TextureWrap::Mirror => wgpu::AddressMode::MirrorRepeat,
        TextureWrap::Clamp => wgpu::AddressMode::ClampToEdge,
    };
    let filter = |linear| {
        if linear {
            wgpu::FilterMode::Linear
        } else {
            wgpu::FilterMode::Nearest
        }
    };
    let all_linear = key.linear_magnify && key.linear_minify;
    context.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("material"),
        address_mode_u: address(key.wrap[0]),
        address_mode_v: address(key.wrap[1]),
        mag_filter: filter(key.linear_magnify),
        min_filter: filter(key.linear_minify),
        mipmap_filter: if key.linear_minify {
            wgpu::MipmapFilterMode::Linear
        } else {
            wgpu::MipmapFilterMode::Nearest
        },
        // WebGPU allows anisotropy only where all filters are linear.
        anisotropy_clamp: if all_linear { context.anisotropy } else { 1 },
        ..Default::default()
    })
}

fn texture_descriptor(
    label: &str,
    width: u32,
    height: u32,
    mip_level_count: u32,
    format: wgpu::TextureFormat,
) -> wgpu::TextureDescriptor<'_> {
    wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    }
}

fn upload_texture(context: &RenderContext, texture: &Texture, encoding: Encoding) -> wgpu::TextureView {
    let limit = context.device.limits().max_texture_dimension_2d;
    let chain = mip_chain(texture, encoding == Encoding::Srgb, limit);
    let format = match encoding {
        Encoding::Srgb => wgpu::TextureFormat::Rgba8UnormSrgb,
        Encoding::Linear => wgpu::TextureFormat::Rgba8Unorm,
    };
    context
        .device
        .create_texture_with_data(
            &context.queue,
            &texture_descriptor(&texture.name, chain.width, chain.height, chain.levels, format),
            wgpu::wgt::TextureDataOrder::LayerMajor,
            &chain.rgba8,
        )
        .create_view(&Default::default())
}

/// Returns the constants of a texture. A transform that is not finite becomes the identity.
fn present_slot(uv_set: u32, uv_transform: Affine2) -> gpu_types::Slot {
    let uv_transform = if uv_transform.is_finite() {
        uv_transform
    } else {
        Affine2::IDENTITY
    };
    let [x, y] = [uv_transform.matrix2.x_axis, uv_transform.matrix2.y_axis];
    gpu_types::Slot {
        uv_matrix: [x.x, x.y, y.x, y.y],
        uv_offset: uv_transform.translation.to_array(),
        uv_set,
        present: 1,
    }
}

fn constants(material: &Material) -> gpu_types::Material {
    let slot = |slot: &Option<TextureSlot>| match slot.as_ref().filter(|slot| is_whole(&slot.texture)) {
        None => gpu_types::Slot {
            uv_matrix: [1.0, 0.0, 0.0, 1.0],
            ..Default::default()
        },
        Some(slot) => present_slot(slot.uv_set, slot.uv_transform),
    };
    // NaN has no nearest allowed number, so it takes the default.
    let within = |x: f32, least: f32, most: f32, default: f32| {
        if x.is_nan() { default } else { x.clamp(least, most) }
    };
    gpu_types::Material {
        base_color: material.base_color.to_array().map(|x| within(x, 0.0, 1.0, 0.0)),
        emissive: material
            .emissive
            .to_array()
            .map(|x| within(x, 0.0, RADIANCE_MAX, 0.0)),
        alpha_cutoff: match material.alpha_mode {
            AlphaMode::Mask(cutoff) => within(cutoff, 0.0, 2.0, 0.5),
            _ => 0.0,
        },
        metallic: within(material.metallic, 0.0, 1.0, 1.0),
        roughness: within(material.roughness, 0.0, 1.0, 1.0),
        normal_scale: within(material.normal_scale, -STEEPEST, STEEPEST, 1.0),
        occlusion_strength: within(material.occlusion_strength, 0.0, 1.0, 1.0),
        unlit: u32::from(material.unlit),
        opaque: u32::from(material.alpha_mode == AlphaMode::Opaque),
        base_color_slot: slot(&material.base_color_texture),
        metallic_roughness_slot: slot(&material.metallic_roughness_texture),
        normal_slot: slot(&material.normal_texture),
        occlusion_slot: slot(&material.occlusion_texture),
        emissive_slot: slot(&material.emissive_texture),
        ..Default::default()
    }
}
