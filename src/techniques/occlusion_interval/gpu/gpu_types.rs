//! Mirrors of the structs of `shaders/techniques/occlusion_interval/resolve.wgsl`.

use bytemuck::{Pod, Zeroable};

use crate::techniques::occlusion_interval::intervals;

/// The window of time of one light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Window {
    /// Start and end of both spans.
    pub spans: [f32; 4],
    /// One divided by the length of both spans.
    pub inverse_width: f32,
    /// Index of the last texel along each side of a page.
    pub last_texel: f32,
    /// Share of the window in which the light shines at all.
    pub shining: f32,
    /// Not used.
    pub unused: f32,
}

impl Window {
    /// The shader's constants for a window into pages of `size` texels along each side, while the light shines in a share
    /// `shining` of the window.
    pub fn new(window: &intervals::Window, size: u32, shining: f32) -> Self {
        let [first, second] = window.spans;
        Self {
            spans: [first[0], first[1], second[0], second[1]],
            inverse_width: window.inverse_width,
            last_texel: size.saturating_sub(1) as f32,
            shining,
            ..Self::default()
        }
    }
}

/// [`IntervalVertex::layers`] of a triangle that is on no page. It has no pairs. Such a triangle shows no shadow.
pub const NO_PAGE: u32 = 0;

/// A corner of a triangle of a baked surface.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct IntervalVertex {
    /// Position in the space of the object, metres.
    pub position_local: [f32; 3],
    /// Place on the page, texels.
    pub texel: [f32; 2],
    /// First layer of the page in the lower half, and number of its pairs in the upper one. [`NO_PAGE`] for a triangle that is
    /// on no page.
    pub layers: u32,
}
