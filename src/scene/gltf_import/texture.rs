//! Import of images and samplers. A texture that cannot be loaded is reported, and the material does without
//! it.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use gltf::json::image::Image;
use gltf::json::texture::{MagFilter, MinFilter, Sampler, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Index, Texture as JsonTexture};

use super::accessors::Accessors;
use super::extensions::{BASISU, SUPPORTED_EXTENSIONS, WEBP, whole_number, why_unread};
use super::{Element, GltfError, Report, SkipKind, buffers, images};
use crate::scene::Texture;
use crate::scene::material::TextureWrap;

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
        let source = match image_of(texture) {
            Ok(source) => source,
            Err(reason) => {
                report.add(SkipKind::Texture, element, 1, reason);
                return Ok(None);
            }
        };
        let image_index: Index<Image> = Index::new(u32::try_from(source).unwrap_or(u32::MAX));
        let image = self.accessors.get(&root.images, image_index, element, "image")?;
        let key = (source, sampler_key(sampler));
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
        let (width, height, rgba8) = match images::decode(encoded, self.left_bytes) {
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
            .or_else(|| image.uri.clone().filter(|uri| buffers::data_of(uri).is_none()));
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

/// The image of a texture: that of an extension if this build reads it, and otherwise the one that any reader may take.
/// The error states why there is none.
fn image_of(texture: &JsonTexture) -> Result<usize, String> {
    let others = texture.extensions.as_ref().map(|extensions| &extensions.others);
    let of = |extension| whole_number(others?.get(extension)?.get("source"));
    let named = [BASISU, WEBP].map(|extension| (extension, of(extension)));
    let readable = named
        .iter()
        .find(|(extension, source)| source.is_some() && SUPPORTED_EXTENSIONS.contains(extension));
    if let Some((_, Some(source))) = readable {
        return Ok(*source);
    }
    // `gltf::json` reads an absent source as the largest index.
    if texture.source.value() != u32::MAX as usize {
        return Ok(texture.source.value());
    }
    Err(match named.iter().find(|(_, source)| source.is_some()) {
        Some((extension, _)) => format!("its image is in {extension}, {}", why_unread(extension)),
        None => "it has no image".to_owned(),
    })
}
