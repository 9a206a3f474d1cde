//! Import of images and samplers. A texture that cannot be loaded is reported, and the material does without
//! it.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use gltf::json::image::Image;
use gltf::json::texture::{MagFilter, MinFilter, Sampler, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Index, Texture as JsonTexture};
use image::{ImageFormat, ImageReader, Limits};

use super::accessors::Accessors;
use super::{Element, GltfError, Report, SkipKind, buffers};
use crate::scene::Texture;
use crate::scene::material::TextureWrap;

/// Largest width and height of an image, texels. wgpu's default limits guarantee half of it.
const MAX_IMAGE_SIZE: u32 = 16384;

/// Largest size of the decoded pixels of all images of a file together, bytes. The limit exists because a
/// file of a few kilobytes can ask for terabytes.
const MAX_IMAGE_BYTES: u64 = 4 << 30;

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct SamplerKey {
    wrap: [TextureWrap; 2],
    linear_magnify: bool,
    linear_minify: bool,
}

/// Loads each image when a material first asks for it, once for each way in which it is sampled.
pub(super) struct Textures<'a> {
    accessors: &'a Accessors<'a>,
    base_dir: Option<&'a Path>,
    loaded: HashMap<(usize, SamplerKey), Option<Arc<Texture>>>,
    left_bytes: u64,
}

impl<'a> Textures<'a> {
    pub fn new(accessors: &'a Accessors<'a>, base_dir: Option<&'a Path>) -> Self {
        Self {
            accessors,
            base_dir,
            loaded: HashMap::new(),
            left_bytes: MAX_IMAGE_BYTES,
        }
    }

    /// The texture, or `None` if it could not be loaded; the reason is then in the report.
    ///
    /// # Errors
    /// An index that is out of range, or an image whose buffer view runs past its buffer.
    pub fn load(
        &mut self,
        index: Index<JsonTexture>,
        user: Element,
        report: &mut Report,
    ) -> Result<Option<Arc<Texture>>, GltfError> {
        let root = self.accessors.root;
        let texture = self.accessors.get(&root.textures, index, user, "texture")?;
        let element = Element::Texture(index.value());
        let sampler = match texture.sampler {
            Some(sampler) => self.accessors.get(&root.samplers, sampler, element, "sampler")?,
            None => &Sampler::default(),
        };
        // The source is absent if it is in an extension.
        if texture.source.value() == u32::MAX as usize {
            report.add(SkipKind::Texture, element, 1, "it has no PNG or JPEG image");
            return Ok(None);
        }
        let image = self
            .accessors
            .get(&root.images, texture.source, element, "image")?;
        let key = (texture.source.value(), sampler_key(sampler));
        if let Some(known) = self.loaded.get(&key) {
            return Ok(known.clone());
        }
        let loaded = self.load_image(key.0, image, key.1, report)?.map(Arc::new);
        self.loaded.insert(key, loaded.clone());
        Ok(loaded)
    }

    fn load_image(
        &mut self,
        index: usize,
        image: &Image,
        sampler: SamplerKey,
        report: &mut Report,
    ) -> Result<Option<Texture>, GltfError> {
        let element = Element::Image(index);
        let from_uri;
        let encoded: &[u8] = match (image.buffer_view, &image.uri) {
            (Some(view), _) => self.accessors.view(element, view)?,
            (None, Some(uri)) => match buffers::read_uri(uri, self.base_dir, None) {
                Ok(bytes) => {
                    from_uri = bytes;
                    &from_uri
                }
                Err(reason) => {
                    report.add(SkipKind::Texture, element, 1, reason);
                    return Ok(None);
                }
            },
            (None, None) => {
                report.add(
                    SkipKind::Texture,
                    element,
                    1,
                    "it has neither a URI nor a buffer view",
                );
                return Ok(None);
            }
        };
        let (width, height, rgba8) = match decode(encoded, self.left_bytes) {
            Ok(pixels) => pixels,
            Err(reason) => {
                report.add(SkipKind::Texture, element, 1, reason);
                return Ok(None);
            }
        };
        self.left_bytes = self.left_bytes.saturating_sub(rgba8.len() as u64);
        let name = image
            .name
            .clone()
            .or_else(|| image.uri.clone().filter(|uri| !uri.starts_with("data:")));
        Ok(Some(Texture {
            name: name.unwrap_or_else(|| element.to_string()),
            width,
            height,
            rgba8,
            wrap: sampler.wrap,
            linear_magnify: sampler.linear_magnify,
            linear_minify: sampler.linear_minify,
        }))
    }
}

fn sampler_key(sampler: &Sampler) -> SamplerKey {
    let wrap = |mode: &Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => TextureWrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => TextureWrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => TextureWrap::Repeat,
    };
    use MinFilter::{Nearest, NearestMipmapLinear, NearestMipmapNearest};
    SamplerKey {
        wrap: [wrap(&sampler.wrap_s), wrap(&sampler.wrap_t)],
        linear_magnify: sampler.mag_filter != Some(Checked::Valid(MagFilter::Nearest)),
        linear_minify: !matches!(
            sampler.min_filter,
            Some(Checked::Valid(
                Nearest | NearestMipmapLinear | NearestMipmapNearest
            ))
        ),
    }
}

/// Decodes to width, height and RGBA bytes. The error states the reason.
fn decode(encoded: &[u8], left_bytes: u64) -> Result<(u32, u32, Vec<u8>), String> {
    let reader = || {
        let mut reader = ImageReader::new(Cursor::new(encoded))
            .with_guessed_format()
            .map_err(|error| error.to_string())?;
        if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
            return Err("it is neither PNG nor JPEG".to_owned());
        }
        let mut limits = Limits::default();
        limits.max_image_width = Some(MAX_IMAGE_SIZE);
        limits.max_image_height = Some(MAX_IMAGE_SIZE);
        reader.limits(limits);
        Ok(reader)
    };
    let broken = |error: image::ImageError| format!("it cannot be decoded: {error}");
    let (width, height) = reader()?.into_dimensions().map_err(broken)?;
    if width == 0 || height == 0 || u64::from(width) * u64::from(height) * 4 > left_bytes {
        return Err(format!("{width} × {height} texels are none or too many"));
    }
    let pixels = reader()?.decode().map_err(broken)?.into_rgba8();
    Ok((pixels.width(), pixels.height(), pixels.into_raw()))
}
