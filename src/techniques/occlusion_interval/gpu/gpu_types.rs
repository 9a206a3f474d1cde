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
    /// Not used.
    pub unused_a: f32,
    /// Not used.
    pub unused_b: f32,
}

impl Window {
    /// The shader's constants for a window into pages of `size` texels along each side.
    pub fn new(window: &intervals::Window, size: u32) -> Self {
        let [first, second] = window.spans;
        Self {
            spans: [first[0], first[1], second[0], second[1]],
            inverse_width: window.inverse_width,
            last_texel: size.saturating_sub(1) as f32,
            ..Self::default()
        }
    }
}

/// A corner of a triangle of a baked surface.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct IntervalVertex {
    /// Position in the space of the object, metres.
    pub position_local: [f32; 3],
    /// Place on the page, texels.
    pub texel: [f32; 2],
    /// First layer of the page in the lower half, and number of its pairs in the upper one.
    pub layers: u32,
}
