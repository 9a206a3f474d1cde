//! Scissor rectangles: the pixels that a light can reach.

use glam::{DVec2, UVec2};

use crate::sets::view::screen::ScreenBounds;

/// A rectangle of pixels inside the picture, with row 0 at the top. It is never empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScissorRect {
    /// First column from the left.
    pub x: u32,
    /// First row from the top.
    pub y: u32,
    /// Number of columns, greater than 0.
    pub width: u32,
    /// Number of rows, greater than 0.
    pub height: u32,
}

/// Pixels by which a rectangle grows before it is rounded outward. Rasterisers snap to 1/256 pixel, and `f32`
/// transforms on the GPU are wrong by some 2⁻²³ of 16384 pixels, which is 1/512. Derived, then doubled twice.
const SLACK: f64 = 1.0 / 32.0;

impl ScissorRect {
    /// The pixels that bounds touch, rounded outward and clipped to the picture. `None` if there are none.
    pub fn around(bounds: &ScreenBounds, viewport: UVec2) -> Option<Self> {
        if bounds.is_empty() {
            return None;
        }
        let size = viewport.as_dvec2();
        let min = (bounds.min - SLACK).floor().clamp(DVec2::ZERO, size).as_uvec2();
        let max = (bounds.max + SLACK).ceil().clamp(DVec2::ZERO, size).as_uvec2();
        let extent = max.saturating_sub(min);
        (extent.x > 0 && extent.y > 0).then_some(Self {
            x: min.x,
            y: min.y,
            width: extent.x,
            height: extent.y,
        })
    }

    /// Whether the pixel lies inside the rectangle.
    pub fn contains(&self, x: u32, y: u32) -> bool {
        x >= self.x && y >= self.y && x - self.x < self.width && y - self.y < self.height
    }

    /// Number of pixels in the rectangle.
    pub fn area(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}
