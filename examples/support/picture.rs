//! Pictures on disk.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use antumbra::insides::linear_from_srgb;
use antumbra::techniques::penumbra_wedge::{EmitterTexture, LightTexture};
use glam::{UVec2, Vec3};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageBuffer, ImageEncoder, ImageFormat, Rgba};

/// Writes sRGB RGBA as PNG.
///
/// # Errors
/// One line that names the file.
pub fn write_png(path: &Path, size: UVec2, rgba8: &[u8]) -> Result<(), String> {
    let image: ImageBuffer<Rgba<u8>, _> = ImageBuffer::from_raw(size.x, size.y, rgba8)
        .ok_or_else(|| format!("{}: not {size} pixels", path.display()))?;
    let mut bytes = Cursor::new(Vec::new());
    image
        .write_to(&mut bytes, ImageFormat::Png)
        .map_err(|error| format!("{}: {error}", path.display()))?;
    write_file(path, &bytes.into_inner())
}

/// Writes a whole file. Encoders that write files themselves drop what a full disk does not take with their last buffer.
fn write_file(path: &Path, bytes: &[u8]) -> Result<(), String> {
    std::fs::write(path, bytes).map_err(|error| format!("{}: {error}", path.display()))
}

/// Writes sRGB RGBA as a PNG without alpha, as small as it gets.
///
/// # Errors
/// One line that names the file.
pub fn write_small_png(path: &Path, size: UVec2, rgba8: &[u8]) -> Result<(), String> {
    let named = |error: String| format!("{}: {error}", path.display());
    if rgba8.len() as u64 != 4 * u64::from(size.x) * u64::from(size.y) {
        return Err(named(format!("not {size} pixels")));
    }
    let rgb: Vec<u8> = rgba8
        .chunks_exact(4)
        .flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])
        .collect();
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive)
        .write_image(&rgb, size.x, size.y, ExtendedColorType::Rgb8)
        .map_err(|error| named(error.to_string()))?;
    write_file(path, &bytes)
}

/// How far two pictures differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Difference {
    /// Number of pixels with a channel that differs by more than [`ROUNDING`].
    pub pixels: usize,
    /// Number of pixels of the picture.
    pub of: usize,
    /// Largest difference of a channel, in steps of 1/255.
    pub most: u8,
}

/// Steps of 1/255 that two devices may round apart.
pub const ROUNDING: u8 = 2;

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { pixels, of, most } = self;
        write!(
            f,
            "{pixels} of {of} pixels differ by more than {ROUNDING}/255, at most by {most}/255"
        )
    }
}

/// Compares sRGB RGBA with a PNG of the same size.
///
/// # Errors
/// One line that names the file: it cannot be read, or has another size.
pub fn difference(path: &Path, size: UVec2, rgba8: &[u8]) -> Result<Difference, String> {
    let other = image::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let other = other.to_rgba8();
    if other.dimensions() != (size.x, size.y) {
        let (width, height) = other.dimensions();
        return Err(format!(
            "{}: {width}x{height} pixels, not {}x{}",
            path.display(),
            size.x,
            size.y
        ));
    }
    let mut difference = Difference::default();
    for (a, b) in other.as_raw().chunks_exact(4).zip(rgba8.chunks_exact(4)) {
        let most = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
        difference.of += 1;
        difference.pixels += usize::from(most > ROUNDING);
        difference.most = difference.most.max(most);
    }
    Ok(difference)
}

/// Writes linear RGB (of RGBA rows) as OpenEXR.
///
/// # Errors
/// One line that names the file.
pub fn write_rgb_exr(path: &Path, size: UVec2, rgba: &[f32]) -> Result<(), String> {
    use exr::prelude::*;
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
        let at = 4 * (at.y() * size.x as usize + at.x());
        (rgba[at], rgba[at + 1], rgba[at + 2])
    });
    let image = Image::from_channels((size.x as usize, size.y as usize), channels);
    let mut bytes = Cursor::new(Vec::new());
    image
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| format!("{}: {error}", path.display()))?;
    write_file(path, &bytes.into_inner())
}

/// Writes one float channel, `Y`, as OpenEXR.
///
/// # Errors
/// One line that names the file.
pub fn write_channel_exr(path: &Path, size: UVec2, values: &[f32]) -> Result<(), String> {
    use exr::prelude::*;
    let channel = AnyChannels::sort(smallvec::smallvec![AnyChannel::new(
        "Y",
        FlatSamples::F32(values.to_vec())
    )]);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(Layer::new(
        (size.x as usize, size.y as usize),
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        channel,
    ))
    .write()
    .to_buffered(&mut bytes)
    .map_err(|error| format!("{}: {error}", path.display()))?;
    write_file(path, &bytes.into_inner())
}

/// Loads a picture as the colours of a light, and shrinks it to at most 128 texels in width and height.
///
/// # Errors
/// One line that names the file.
pub fn light_texture(path: &Path) -> Result<EmitterTexture, String> {
    let named = |error: &dyn std::error::Error| format!("{}: {error}", path.display());
    let loaded = image::open(path).map_err(|error| named(&error))?;
    let picture = if loaded.width().max(loaded.height()) > 128 {
        loaded.thumbnail(128, 128)
    } else {
        loaded
    };
    let picture = picture.to_rgb8();
    let linear = |byte: u8| linear_from_srgb(f32::from(byte) / 255.0);
    let texels = picture
        .pixels()
        .map(|texel| Vec3::from_array(texel.0.map(linear)));
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let texture = LightTexture::new(width, height, vec![texels.collect()]).map_err(|error| named(&error))?;
    Ok(EmitterTexture {
        texture: Arc::new(texture),
        frame: 0,
    })
}
