//! The picture of a cookie.

#[cfg(any(feature = "render", feature = "gltf"))]
use std::path::Path;
use std::path::PathBuf;
use std::sync::Arc;

use glam::Vec3;

use super::levels::Level;

/// A picture that a light shines through: linear RGB, each component the share of light that passes.
///
/// Lights hold it in an `Arc`, so many lights share one picture, and its texture on the GPU is made once.
#[derive(Debug, PartialEq)]
pub struct CookieImage {
    name: String,
    level: Level,
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
        Ok(Arc::new(Self { name, level }))
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

    /// Width of the picture, texels.
    pub fn width(&self) -> u32 {
        self.level.width
    }

    /// Height of the picture, texels.
    pub fn height(&self) -> u32 {
        self.level.height
    }

    /// Linear RGB of the texels, in rows from the top.
    pub fn texels(&self) -> &[Vec3] {
        &self.level.texels
    }

    /// The picture as its first level.
    pub(super) fn level(&self) -> &Level {
        &self.level
    }

    /// Returns the mip levels down to 1×1, largest first. Each is the average of the one before. The first level is the
    /// first one whose sides have at most `limit` texels.
    #[cfg(feature = "render")]
    pub(crate) fn levels(&self, limit: u32) -> Vec<Level> {
        let mut levels = vec![self.level.clone()];
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
}

/// Source: IEC 61966-2-1, the sRGB transfer function.
#[cfg(any(feature = "render", feature = "gltf"))]
fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}
