//! Draws the error of an answer as a picture.

use glam::UVec2;

use super::error::ReferenceError;
use super::metrics::{differences, edge_band};
use super::visibility::VisibilityImage;

/// An 8-bit RGBA picture, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DifferenceImage {
    /// Width and height, pixels.
    pub size: UVec2,
    /// The pixels, four bytes each, rows from the top.
    pub rgba8: Vec<u8>,
}

/// Draws where `got` differs from the truth.
///
/// | colour | pixel |
/// | --- | --- |
/// | grey | does not count |
/// | green to red | error 0 to 1, with yellow at ½ |
/// | faint green to red | error 0 to 1 within one pixel of an edge, where a hard shadow is not judged |
///
/// Shadow that should be lit and light that should be shadow look alike. Brightness follows the truth a
/// little (shadowed pixels are darker), so that the scene's shape is recognisable.
///
/// # Errors
/// [`ReferenceError::Size`] if the images differ in size.
pub fn difference_image(
    truth: &VisibilityImage,
    got: &VisibilityImage,
) -> Result<DifferenceImage, ReferenceError> {
    let band = edge_band(truth, 1);
    let pixels = differences(truth, got)?.zip(truth.values()).zip(band);
    let rgba8 = pixels.flat_map(|((difference, &truth), in_band)| {
        let Some(difference) = difference else {
            return [96, 96, 96, 255];
        };
        let error = difference.min(1.0);
        let brightness = 128.0 + 127.0 * f64::from(truth).max(error).clamp(0.0, 1.0);
        let strength = if in_band { 0.4 } else { 1.0 };
        let channel = |share: f64| (brightness * (share.min(1.0) * strength + (1.0 - strength) * 0.5)) as u8;
        [
            channel(2.0 * error),
            channel(2.0 * (1.0 - error)),
            channel(0.0),
            255,
        ]
    });
    Ok(DifferenceImage {
        size: truth.size(),
        rgba8: rgba8.collect(),
    })
}
