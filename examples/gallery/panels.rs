//! Turns visibility into pictures, and makes pictures smaller.

use antumbra::conventions::RADIANCE_MAX;
use antumbra::insides::linear_from_srgb;
use antumbra::reference::{VisibilityImage, edge_band};
use glam::{UVec2, Vec3};

/// Colour of pixels that let light through where there is none, sRGB.
const LEAK: [u8; 3] = [255, 84, 24];

/// Colour of pixels that are dark where there is light, sRGB.
const FALSE_SHADOW: [u8; 3] = [30, 144, 255];

/// Colour of pixels where the truth does not count, sRGB.
const NOT_JUDGED: [u8; 4] = [44, 50, 64, 255];

/// Draws visibility: white where the light is seen, black where it is not, slate where `truth` does not count.
pub fn visibility(image: &VisibilityImage, truth: &VisibilityImage) -> Vec<u8> {
    let pixels = image.values().iter().zip(truth.values());
    pixels
        .flat_map(|(&value, truth)| {
            if truth.is_nan() {
                NOT_JUDGED
            } else {
                let grey = 16.0 + 224.0 * value.clamp(0.0, 1.0);
                [grey as u8, grey as u8, grey as u8, 255]
            }
        })
        .collect()
}

/// Draws errors over a transparent picture: orange where the answer is too bright, blue where it is too dark, as opaque as
/// the error is large. Within a pixel of an edge of a hard shadow, which is not judged, it is half as opaque.
///
/// # Errors
/// The images differ in size.
pub fn overlay(truth: &VisibilityImage, got: &VisibilityImage, is_soft: bool) -> Result<Vec<u8>, String> {
    if truth.size() != got.size() {
        return Err(format!("{} is not the size {}", got.size(), truth.size()));
    }
    let band = edge_band(truth, 1);
    let pixels = truth.values().iter().zip(got.values()).zip(band);
    let draw = |((&truth, &got), in_band): ((&f32, &f32), bool)| {
        if truth.is_nan() {
            return [0; 4];
        }
        let difference = if got.is_finite() { got - truth } else { 1.0 };
        let [red, green, blue] = if difference > 0.0 { LEAK } else { FALSE_SHADOW };
        let strength = if in_band && !is_soft { 0.5 } else { 1.0 };
        // The root shows small errors as well.
        let opacity = difference.abs().min(1.0).sqrt() * strength;
        [red, green, blue, (255.0 * opacity) as u8]
    };
    Ok(pixels.flat_map(draw).collect())
}

/// Maps linear radiance (RGBA rows) to sRGB as the renderer's last pass does.
///
/// Source: Khronos 2024, "Khronos PBR Neutral Tone Mapper", formula of its specification.
/// Twin of `shaders/passes/tonemap.wgsl`.
pub fn tonemapped(radiance: &[f32], exposure: f32) -> Vec<u8> {
    let pixels = radiance.chunks_exact(4).flat_map(|pixel| {
        let shown = Vec3::from_slice(pixel) * exposure;
        let color = pbr_neutral(shown.clamp(Vec3::ZERO, Vec3::splat(RADIANCE_MAX)));
        let [red, green, blue] = color.to_array().map(encoded);
        [red, green, blue, 255]
    });
    pixels.collect()
}

fn pbr_neutral(radiance: Vec3) -> Vec3 {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let lowest = radiance.min_element();
    let offset = if lowest < 0.08 {
        lowest - 6.25 * lowest * lowest
    } else {
        0.04
    };
    let color = radiance - offset;
    let peak = color.max_element();
    if peak < START {
        return color;
    }
    let room = 1.0 - START;
    let compressed = 1.0 - room * room / (peak + room - START);
    let grey = 1.0 - 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    (color * (compressed / peak)).lerp(Vec3::splat(compressed), grey)
}

/// Makes an opaque picture of `size` pixels smaller, or leaves it as large as it is. Each pixel of the result is the mean of
/// what it covers, in linear light.
pub fn reduce(size: UVec2, rgba8: &[u8], reduced: UVec2) -> Vec<u8> {
    let columns = covered(size.x, reduced.x);
    let rows = covered(size.y, reduced.y);
    let light: [f32; 256] = std::array::from_fn(|byte| linear_from_srgb(byte as f32 / 255.0));
    let mut out = Vec::with_capacity(4 * reduced.element_product() as usize);
    for row in &rows {
        for column in &columns {
            let mut sum = Vec3::ZERO;
            for &(y, height) in row {
                for &(x, width) in column {
                    let at = 4 * (y * size.x + x) as usize;
                    let color = [rgba8[at], rgba8[at + 1], rgba8[at + 2]];
                    sum += width * height * Vec3::from(color.map(|byte| light[usize::from(byte)]));
                }
            }
            let [red, green, blue] = sum.to_array().map(encoded);
            out.extend([red, green, blue, 255]);
        }
    }
    out
}

/// For each pixel of a row of `reduced` pixels, the pixels that it covers in the same row of `length` pixels, with the share of
/// it that each of them fills.
fn covered(length: u32, reduced: u32) -> Vec<Vec<(u32, f32)>> {
    let shares = |pixel: u32| {
        // Borders in parts of a pixel, of which `reduced` make one.
        let [begin, end] = [pixel * length, (pixel + 1) * length];
        let share = |at: u32| {
            let inside = end.min((at + 1) * reduced) - begin.max(at * reduced);
            (at, inside as f32 / length as f32)
        };
        (begin / reduced..end.div_ceil(reduced)).map(share).collect()
    };
    (0..reduced).map(shares).collect()
}

/// Puts pictures of one size side by side.
pub fn side_by_side(size: UVec2, pictures: &[&[u8]], gap: u32) -> (UVec2, Vec<u8>) {
    let count = pictures.len() as u32;
    let total = UVec2::new(count * size.x + count.saturating_sub(1) * gap, size.y);
    let mut out = Vec::with_capacity(4 * total.element_product() as usize);
    for y in 0..size.y {
        for (index, pixels) in pictures.iter().enumerate() {
            if index > 0 {
                out.extend([255u8, 255, 255, 0].repeat(gap as usize));
            }
            let row = 4 * (y * size.x) as usize;
            out.extend(&pixels[row..row + 4 * size.x as usize]);
        }
    }
    (total, out)
}

fn encoded(value: f32) -> u8 {
    let value = if value <= 0.003_130_8 {
        value * 12.92
    } else {
        1.055 * value.powf(1.0 / 2.4) - 0.055
    };
    (value * 255.0).round().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reduced_pixel_is_the_mean_of_what_it_covers() {
        // Three columns become two: each takes one whole and half of the middle one.
        let [white, black] = [[255; 4], [0, 0, 0, 255]];
        let row = |columns: [[u8; 4]; 3]| columns.concat();
        let size = UVec2::new(3, 1);
        let halves = |columns| reduce(size, &row(columns), UVec2::new(2, 1));
        let [two_thirds, third] = [2.0 / 3.0, 1.0 / 3.0].map(encoded);
        assert_eq!(halves([white, black, black])[..3], [two_thirds; 3]);
        assert_eq!(halves([white, black, black])[4..], black);
        assert_eq!(halves([black, white, black])[..3], [third; 3]);
        assert_eq!(halves([black, white, black])[4..7], [third; 3]);
        assert_eq!(
            reduce(size, &row([white, black, white]), size),
            row([white, black, white])
        );
    }

    #[test]
    fn what_reduced_pixels_cover_is_whole() {
        for (length, reduced) in [(960, 640), (2, 1), (81, 54), (7, 5), (5, 5)] {
            let pixels = covered(length, reduced);
            let mut sums = vec![0.0; length as usize];
            for pixel in &pixels {
                let whole: f32 = pixel.iter().map(|(_, share)| share).sum();
                assert!((whole - 1.0).abs() < 1e-5, "{length} to {reduced}: {pixel:?}");
                pixel.iter().for_each(|&(at, share)| sums[at as usize] += share);
            }
            let even = reduced as f32 / length as f32;
            assert!(
                sums.iter().all(|sum| (sum - even).abs() < 1e-5),
                "{length} to {reduced}"
            );
        }
    }
}
