//! Pictures in files: from encoded bytes to RGBA texels.

use std::io::Cursor;

use image::{ImageFormat, ImageReader, Limits};

/// Largest width and height of an image, texels. wgpu's default limits guarantee half of it.
const MAX_IMAGE_SIZE: u32 = 16384;

/// Width, height and RGBA bytes.
type Picture = (u32, u32, Vec<u8>);

/// First bytes of a KTX2 file. Source: KTX 2.0 specification, section 3.1.
const KTX2: &[u8] = b"\xABKTX 20\xBB\r\n\x1A\n";

/// Decodes a picture of at most `left_bytes` texel bytes, whatever its file says of its type. The error states the
/// reason.
pub(super) fn decode(encoded: &[u8], left_bytes: u64) -> Result<Picture, String> {
    let is_webp = encoded.starts_with(b"RIFF") && encoded.get(8..12) == Some(b"WEBP");
    if is_webp {
        webp(encoded, left_bytes)
    } else if encoded.starts_with(KTX2) {
        basisu(encoded, left_bytes)
    } else {
        png_or_jpeg(encoded, left_bytes)
    }
}

/// Refuses pictures without texels, and those that are too large.
fn check_size(width: u32, height: u32, left_bytes: u64) -> Result<(), String> {
    let fits = width.max(height) <= MAX_IMAGE_SIZE && u64::from(width) * u64::from(height) * 4 <= left_bytes;
    if width == 0 || height == 0 || !fits {
        return Err(format!("{width} × {height} texels are none or too many"));
    }
    Ok(())
}

fn broken(error: impl std::fmt::Display) -> String {
    format!("it cannot be decoded: {error}")
}

fn png_or_jpeg(encoded: &[u8], left_bytes: u64) -> Result<Picture, String> {
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
    let (width, height) = reader()?.into_dimensions().map_err(broken)?;
    check_size(width, height, left_bytes)?;
    let pixels = reader()?.decode().map_err(broken)?.into_rgba8();
    Ok((pixels.width(), pixels.height(), pixels.into_raw()))
}

#[cfg(not(feature = "gltf-webp"))]
fn webp(_encoded: &[u8], _left_bytes: u64) -> Result<Picture, String> {
    use super::extensions::{WEBP, why_unread};
    Err(format!("it is WebP, {}", why_unread(WEBP)))
}

#[cfg(feature = "gltf-webp")]
fn webp(encoded: &[u8], left_bytes: u64) -> Result<Picture, String> {
    let mut decoder = image_webp::WebPDecoder::new(Cursor::new(encoded)).map_err(broken)?;
    let (width, height) = decoder.dimensions();
    check_size(width, height, left_bytes)?;
    let channels = if decoder.has_alpha() { 4 } else { 3 };
    let mut bytes = vec![0; width as usize * height as usize * channels];
    decoder.read_image(&mut bytes).map_err(broken)?;
    let rgba8 = match channels {
        4 => bytes,
        _ => bytes
            .as_chunks::<3>()
            .0
            .iter()
            .flat_map(|&[r, g, b]| [r, g, b, 255])
            .collect(),
    };
    Ok((width, height, rgba8))
}

#[cfg(not(feature = "gltf-basisu"))]
fn basisu(_encoded: &[u8], _left_bytes: u64) -> Result<Picture, String> {
    use super::extensions::{BASISU, why_unread};
    Err(format!("it is KTX2, {}", why_unread(BASISU)))
}

#[cfg(feature = "gltf-basisu")]
fn basisu(encoded: &[u8], left_bytes: u64) -> Result<Picture, String> {
    use basisu::{DecodeFlags, TargetFormat, Transcoder};
    let broken =
        |error: basisu::Error| format!("it is no KTX2 with Basis Universal that can be decoded: {error:?}");
    let transcoder = Transcoder::new(encoded).map_err(broken)?;
    let (width, height) = transcoder.base_dimensions();
    check_size(width, height, left_bytes)?;
    let rgba8 = transcoder
        .transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE)
        .map_err(broken)?;
    if rgba8.len() as u64 != u64::from(width) * u64::from(height) * 4 {
        return Err(format!(
            "it has {} bytes for {width} × {height} texels",
            rgba8.len()
        ));
    }
    Ok((width, height, rgba8))
}
