//! Pictures on disk.

use std::path::Path;
use std::sync::Arc;

use antumbra::techniques::penumbra_wedge::{EmitterTexture, LightTexture};
use glam::{UVec2, Vec3};
use image::{ImageBuffer, Rgba};

/// Writes sRGB RGBA as PNG.
///
/// # Errors
/// One line that names the file.
pub fn write_png(path: &Path, size: UVec2, rgba8: &[u8]) -> Result<(), String> {
    let image: ImageBuffer<Rgba<u8>, _> = ImageBuffer::from_raw(size.x, size.y, rgba8)
        .ok_or_else(|| format!("{}: not {size} pixels", path.display()))?;
    image
        .save(path)
        .map_err(|error| format!("{}: {error}", path.display()))
}

/// Writes linear RGB (of RGBA rows) as OpenEXR.
///
/// # Errors
/// One line that names the file.
pub fn write_rgb_exr(path: &Path, size: UVec2, rgba: &[f32]) -> Result<(), String> {
    exr::prelude::write_rgb_file(path, size.x as usize, size.y as usize, |x, y| {
        let at = 4 * (y * size.x as usize + x);
        (rgba[at], rgba[at + 1], rgba[at + 2])
    })
    .map_err(|error| format!("{}: {error}", path.display()))
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
    Image::from_layer(Layer::new(
        (size.x as usize, size.y as usize),
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        channel,
    ))
    .write()
    .to_file(path)
    .map_err(|error| format!("{}: {error}", path.display()))
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
    let linear = |byte: u8| {
        let value = f32::from(byte) / 255.0;
        if value <= 0.04045 {
            value / 12.92
        } else {
            ((value + 0.055) / 1.055).powf(2.4)
        }
    };
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
