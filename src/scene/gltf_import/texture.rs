//! Import of images and samplers. A texture that cannot be loaded is reported, and the material does without
//! it.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use gltf::json::image::Image;
use gltf::json::texture::{MagFilter, MinFilter, Sampler, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Index, Texture as JsonTexture};
use smallvec::SmallVec;

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
    /// An index that is out of range.
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
        let sources = match images_of(texture, root.images.len()) {
            Ok(sources) => sources,
            Err(reason) => {
                report.add(SkipKind::Texture, element, 1, reason);
                return Ok(None);
            }
        };
        for source in sources {
            let index: Index<Image> = Index::new(u32::try_from(source).unwrap_or(u32::MAX));
            let image = self.accessors.get(&root.images, index, element, "image")?;
            let key = (source, sampler_key(sampler));
            let known = self.loaded.get(&key).cloned();
            let loaded = match known {
                Some(known) => known,
                None => self.load_image(source, image, key.1, report)?.map(Arc::new),
            };
            self.loaded.insert(key, loaded.clone());
            if loaded.is_some() {
                return Ok(loaded);
            }
        }
        Ok(None)
    }

    /// The bytes of an image's file, or why there are none.
    ///
    /// # Errors
    /// An index that is out of range.
    fn encoded(&self, element: Element, image: &Image) -> Result<Result<Cow<'a, [u8]>, String>, GltfError> {
        let accessors = self.accessors;
        match (image.buffer_view, &image.uri) {
            (Some(view), _) => match accessors
                .view(element, view)
                .map_err(|error| error.read_by(element))
            {
                Ok(bytes) => Ok(Ok(Cow::Borrowed(bytes))),
                Err(GltfError::Invalid { reason, .. }) => Ok(Err(reason)),
                Err(error) => Err(error),
            },
            (None, Some(uri)) => Ok(buffers::read_uri(uri, self.base_dir, None).map(Cow::Owned)),
            (None, None) => Ok(Err("it has neither a URI nor a buffer view".to_owned())),
        }
    }

    fn load_image(
        &mut self,
        index: usize,
        image: &Image,
        sampler: SamplerKey,
        report: &mut Report,
    ) -> Result<Option<Texture>, GltfError> {
        let element = Element::Image(index);
        let encoded = self.encoded(element, image)?;
        let decoded = encoded.and_then(|encoded| images::decode(&encoded, self.left_bytes));
        let (width, height, rgba8) = match decoded {
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

/// The images of a texture, best first: those of extensions that this build reads, and then the one that any reader may take.
/// A file has `image_count` images; the last one is left out if it is not among them and there are others. The error states
/// why there is none.
fn images_of(texture: &JsonTexture, image_count: usize) -> Result<SmallVec<[usize; 3]>, String> {
    let others = texture.extensions.as_ref().map(|extensions| &extensions.others);
    let of = |extension| whole_number(others?.get(extension)?.get("source"));
    let named = [BASISU, WEBP].map(|extension| (extension, of(extension)));
    let readable = named
        .iter()
        .filter(|(extension, _)| SUPPORTED_EXTENSIONS.contains(extension));
    let mut images: SmallVec<[usize; 3]> = readable.filter_map(|(_, source)| *source).collect();
    // `gltf::json` reads an absent source as the largest index.
    let plain = Some(texture.source.value()).filter(|&source| source != u32::MAX as usize);
    images.extend(plain.filter(|&source| images.is_empty() || source < image_count));
    if !images.is_empty() {
        return Ok(images);
    }
    Err(match named.iter().find(|(_, source)| source.is_some()) {
        Some((extension, _)) => format!("its image is in {extension}, {}", why_unread(extension)),
        None => "it has no image".to_owned(),
    })
}
