//! Textures of materials and their samplers on the GPU.

use std::collections::HashMap;
use std::sync::Arc;

use smallvec::SmallVec;
use wgpu::util::DeviceExt;

use crate::render::RenderContext;
use crate::render::gpu::mipmaps::mip_chain;
use crate::scene::material::TextureWrap;
use crate::scene::{Material, Texture, TextureSlot};

/// The encoding in which a texture's texels are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Colours.
    Srgb,
    /// Numbers.
    Linear,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct SamplerKey {
    wrap: [TextureWrap; 2],
    linear_magnify: bool,
    linear_minify: bool,
}

/// The textures and samplers that materials hold.
#[derive(Debug, Default)]
pub struct Textures {
    /// The textures by their addresses. An entry keeps its texture alive, and a texture has one entry for all
    /// encodings: two entries would keep each other's texture for ever.
    known: HashMap<usize, KnownTexture>,
    samplers: HashMap<SamplerKey, wgpu::Sampler>,
}

/// A texture that is on the device in at least one encoding.
#[derive(Debug)]
struct KnownTexture {
    source: Arc<Texture>,
    /// The view of each encoding, in the order of [`Encoding`].
    views: [Option<wgpu::TextureView>; 2],
}

fn address(texture: &Arc<Texture>) -> usize {
    Arc::as_ptr(texture) as usize
}

/// A texture that is not on the device.
#[derive(Debug)]
pub struct MissingTexture<'a> {
    texture: &'a Arc<Texture>,
    encoding: Encoding,
}

/// A texture that was uploaded.
#[derive(Debug)]
pub struct UploadedTexture {
    texture: Arc<Texture>,
    encoding: Encoding,
    view: wgpu::TextureView,
}

impl MissingTexture<'_> {
    /// Makes the mipmaps and uploads them. Threads share the work, and the calling one may run other tasks while it waits:
    /// hold no lock.
    pub fn upload(&self, context: &RenderContext) -> UploadedTexture {
        UploadedTexture {
            texture: self.texture.clone(),
            encoding: self.encoding,
            view: upload_texture(context, self.texture, self.encoding),
        }
    }
}

/// The number of textures of a material.
pub const TEXTURE_COUNT: usize = 7;

/// The textures of a material in the order of their bindings, and how each is read.
pub fn slots(material: &Material) -> [(&Option<TextureSlot>, Encoding); TEXTURE_COUNT] {
    [
        (&material.base_color_texture, Encoding::Srgb),
        (&material.metallic_roughness_texture, Encoding::Linear),
        (&material.normal_texture, Encoding::Linear),
        (&material.occlusion_texture, Encoding::Linear),
        (&material.emissive_texture, Encoding::Srgb),
        (&material.clearcoat_texture, Encoding::Linear),
        (&material.clearcoat_roughness_texture, Encoding::Linear),
    ]
}

/// The texture of a slot, if it can be shown.
pub fn whole_texture(slot: &Option<TextureSlot>) -> Option<&Arc<Texture>> {
    slot.as_ref().map(|slot| &slot.texture).filter(|t| is_whole(t))
}

impl Textures {
    /// Returns the textures of a material that are not on the device, each once.
    pub fn missing<'a>(&self, material: &'a Material) -> SmallVec<[MissingTexture<'a>; TEXTURE_COUNT]> {
        let mut missing: SmallVec<[MissingTexture<'a>; TEXTURE_COUNT]> = SmallVec::new();
        for (slot, encoding) in slots(material) {
            let Some(texture) = whole_texture(slot) else {
                continue;
            };
            let is_listed = missing
                .iter()
                .any(|other| Arc::ptr_eq(other.texture, texture) && other.encoding == encoding);
            if !is_listed && self.find(texture, encoding).is_none() {
                missing.push(MissingTexture { texture, encoding });
            }
        }
        missing
    }

    /// Adds a texture, unless another view has added it meanwhile.
    pub fn insert(&mut self, uploaded: UploadedTexture) {
        let UploadedTexture {
            texture,
            encoding,
            view,
        } = uploaded;
        let known = self.known.entry(address(&texture)).or_insert(KnownTexture {
            source: texture,
            views: [None, None],
        });
        known.views[encoding as usize].get_or_insert(view);
    }

    /// Removes the textures that no material holds.
    pub fn forget_unused(&mut self) {
        self.known
            .retain(|_, texture| Arc::strong_count(&texture.source) > 1);
    }

    fn find(&self, texture: &Arc<Texture>, encoding: Encoding) -> Option<&wgpu::TextureView> {
        self.known.get(&address(texture))?.views[encoding as usize].as_ref()
    }

    /// Yields the textures that are on the device, in no order.
    pub fn iter(&self) -> impl Iterator<Item = &Texture> {
        self.known.values().map(|known| &*known.source)
    }

    /// Returns the number of textures on the device. One in two encodings counts twice.
    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.known
            .values()
            .map(|texture| texture.views.iter().flatten().count())
            .sum()
    }

    /// Returns a texture that is on the device already.
    pub fn view(&self, slot: &Option<TextureSlot>, encoding: Encoding) -> Option<wgpu::TextureView> {
        self.find(whole_texture(slot)?, encoding).cloned()
    }

    /// Returns the sampler of a slot; that of an empty slot repeats.
    pub fn sampler(&mut self, context: &RenderContext, slot: Option<&TextureSlot>) -> wgpu::Sampler {
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

/// Describes a two-dimensional texture that shaders sample.
pub fn texture_descriptor(
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
