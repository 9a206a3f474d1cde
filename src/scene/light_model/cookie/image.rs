//! The picture of a cookie.

#[cfg(any(feature = "render", feature = "gltf"))]
use std::path::Path;
use std::path::PathBuf;
use std::sync::Arc;

use glam::Vec3;

use super::levels::Level;
#[cfg(any(feature = "render", feature = "gltf"))]
use crate::scene::srgb::linear_from_srgb;

/// A picture that a light shines through: linear RGB, each component the share of light that passes.
///
/// It is flat, or a cube around the light ([`CookieImage::cube`], [`CookieImage::load_cube`]). Lights hold it in an
/// `Arc`, so many lights share one picture, and its texture on the GPU is made once.
#[derive(Debug, PartialEq)]
pub struct CookieImage {
    pub(super) name: String,
    pub(super) faces: Faces,
}

/// The texels of a picture.
#[derive(Debug, PartialEq)]
pub(super) enum Faces {
    /// One flat picture.
    Flat(Level),
    /// The faces of a cube, in the order of [`CookieImage::cube`].
    Cube(Box<[Level; 6]>),
}

/// Why a picture cannot be a cookie.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CookieImageError {
    /// The file cannot be read.
    #[error("{}: {error}", path.display())]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// Why the file cannot be read.
        #[source]
        error: std::io::Error,
    },
    /// The bytes are no picture, or one in a format that is not read.
    #[error("{name}: {message}")]
    Format {
        /// Name of the picture.
        name: String,
        /// What is wrong with the bytes.
        message: String,
    },
    /// The picture has no texels, or their number does not fit its size.
    #[error("{name}: {texels} texels do not fill {width}×{height}")]
    Size {
        /// Name of the picture.
        name: String,
        /// Width, texels.
        width: u32,
        /// Height, texels.
        height: u32,
        /// Number of texels.
        texels: usize,
    },
    /// The picture does not have the shape of a cube's faces.
    #[error(
        "{name}: {width}×{height} texels are no faces of a cube; a cross has 4×3 or 3×4 square faces, a row or a \
         column 6"
    )]
    Cube {
        /// Name of the picture.
        name: String,
        /// Width, texels.
        width: u32,
        /// Height, texels.
        height: u32,
    },
    /// A picture that is to be the face of a cube is not a square, of another size than the first one, or a cube.
    #[error("{name}: {width}×{height} texels are no face of a cube whose faces have {side}×{side}")]
    Face {
        /// Name of the picture.
        name: String,
        /// Width, texels.
        width: u32,
        /// Height, texels.
        height: u32,
        /// Texels along a side of the first face.
        side: u32,
    },
    /// A texel is not finite, negative, or too large for a half float.
    #[error("{name}: texel ({x}, {y}) is {color}, its components must be in 0..=65504")]
    Texel {
        /// Name of the picture.
        name: String,
        /// Column of the texel, from the left.
        x: u32,
        /// Row of the texel, from the top.
        y: u32,
        /// The texel.
        color: Vec3,
    },
}

impl CookieImage {
    /// Makes a picture of linear RGB texels, in rows from the top. Components may be greater than 1; the light is then
    /// brighter than without a cookie.
    ///
    /// # Errors
    /// [`CookieImageError::Size`] or [`CookieImageError::Texel`] with the name.
    pub fn from_linear(
        name: &str,
        width: u32,
        height: u32,
        texels: Vec<Vec3>,
    ) -> Result<Arc<Self>, CookieImageError> {
        const LARGEST: f32 = 65504.0;
        let name = name.to_owned();
        let expected = u64::from(width) * u64::from(height);
        if expected == 0 || texels.len() as u64 != expected {
            let texels = texels.len();
            return Err(CookieImageError::Size {
                name,
                width,
                height,
                texels,
            });
        }
        let usable = |color: &Vec3| color.to_array().iter().all(|x| (0.0..=LARGEST).contains(x));
        if let Some(at) = texels.iter().position(|color| !usable(color)) {
            return Err(CookieImageError::Texel {
                name,
                x: (at % width as usize) as u32,
                y: (at / width as usize) as u32,
                color: texels[at],
            });
        }
        let level = Level {
            width,
            height,
            texels,
        };
        let faces = Faces::Flat(level);
        Ok(Arc::new(Self { name, faces }))
    }

    /// Reads a picture file: PNG or JPEG with 8 or 16 bits, encoded as sRGB, or OpenEXR, which is linear. Colour is
    /// multiplied by alpha, so transparent texels hold the light back.
    ///
    /// # Errors
    /// [`CookieImageError`] names the file.
    #[cfg(any(feature = "render", feature = "gltf"))]
    pub fn load(path: &Path) -> Result<Arc<Self>, CookieImageError> {
        let bytes = std::fs::read(path).map_err(|error| CookieImageError::Read {
            path: path.to_owned(),
            error,
        })?;
        Self::decode(&path.display().to_string(), &bytes)
    }

    /// Reads the bytes of a picture file, as [`CookieImage::load`] does.
    ///
    /// # Errors
    /// [`CookieImageError`] has the name.
    #[cfg(any(feature = "render", feature = "gltf"))]
    pub fn decode(name: &str, bytes: &[u8]) -> Result<Arc<Self>, CookieImageError> {
        use image::DynamicImage;
        let picture = image::load_from_memory(bytes).map_err(|error| CookieImageError::Format {
            name: name.to_owned(),
            message: error.to_string(),
        })?;
        let is_linear = matches!(
            picture,
            DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)
        );
        let picture = picture.into_rgba32f();
        let (width, height) = picture.dimensions();
        let texels = picture.pixels().map(|texel| {
            let [r, g, b, alpha] = texel.0;
            let color = Vec3::new(r, g, b);
            let color = if is_linear {
                color
            } else {
                Vec3::from_array(color.to_array().map(linear_from_srgb))
            };
            color * alpha
        });
        Self::from_linear(name, width, height, texels.collect())
    }

    /// Name of the picture, used in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Width of the picture, or of a face of a cube, texels.
    pub fn width(&self) -> u32 {
        self.first().width
    }

    /// Height of the picture, or of a face of a cube, texels.
    pub fn height(&self) -> u32 {
        self.first().height
    }

    /// Linear RGB of the texels, in rows from the top. Those of a cube are the texels of its first face.
    pub fn texels(&self) -> &[Vec3] {
        &self.first().texels
    }

    /// Whether the picture is a cube around the light.
    pub fn is_cube(&self) -> bool {
        matches!(self.faces, Faces::Cube(_))
    }

    /// The picture as its first level, or the first face of a cube.
    pub(super) fn first(&self) -> &Level {
        match &self.faces {
            Faces::Flat(level) => level,
            Faces::Cube(faces) => &faces[0],
        }
    }

    /// The first level of each face: one, or the six of a cube.
    pub(super) fn faces(&self) -> &[Level] {
        match &self.faces {
            Faces::Flat(level) => std::slice::from_ref(level),
            Faces::Cube(faces) => &faces[..],
        }
    }

    /// Returns the mip levels of each face down to 1×1, largest first. Each is the average of the one before. The first
    /// level is the first one whose sides have at most `limit` texels.
    #[cfg(feature = "render")]
    pub(crate) fn levels(&self, limit: u32) -> impl Iterator<Item = Vec<Level>> + '_ {
        self.faces().iter().map(move |face| levels(face, limit))
    }
}

/// The mip levels of a picture down to 1×1, largest first. The first level is the first one whose sides have at most
/// `limit` texels.
#[cfg(feature = "render")]
fn levels(first: &Level, limit: u32) -> Vec<Level> {
    let mut levels = vec![first.clone()];
    while let Some(next) = levels.last().and_then(Level::halved) {
        if levels
            .last()
            .is_some_and(|level| level.width.max(level.height) > limit)
        {
            levels.clear();
        }
        levels.push(next);
    }
    levels
}
