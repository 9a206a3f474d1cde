//! Turns visibility into pictures, and makes pictures smaller.

use antumbra::reference::VisibilityImage;
use glam::UVec2;

/// Names of the panels in file names, in their order.
pub const NAMES: [&str; 5] = ["picture", "volumes", "visibility", "truth", "difference"];

/// Titles of the panels above the pictures, in their order.
pub const TITLES: [&str; 5] = [
    "Picture, all lights",
    "Shadow volumes",
    "Visibility, rendered",
    "Visibility, ray-cast",
    "Difference",
];

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

/// Halves the size of a picture, averaging in linear light. Width and height must be even.
pub fn halve(size: UVec2, rgba8: &[u8]) -> (UVec2, Vec<u8>) {
    let half = size / 2;
    let mut out = Vec::with_capacity(4 * half.element_product() as usize);
    for y in 0..half.y {
        for x in 0..half.x {
            for channel in 0..4 {
                let sum: f32 = [(0, 0), (1, 0), (0, 1), (1, 1)]
                    .map(|(dx, dy)| {
                        let at = (2 * y + dy) * size.x + 2 * x + dx;
                        linear(rgba8[4 * at as usize + channel])
                    })
                    .iter()
                    .sum();
                out.push(encoded(sum * 0.25));
            }
        }
    }
    (half, out)
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

fn linear(byte: u8) -> f32 {
    let value = f32::from(byte) / 255.0;
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

fn encoded(value: f32) -> u8 {
    let value = if value <= 0.003_130_8 {
        value * 12.92
    } else {
        1.055 * value.powf(1.0 / 2.4) - 0.055
    };
    (value * 255.0).round().clamp(0.0, 255.0) as u8
}
