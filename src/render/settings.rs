//! The settings by which frames are drawn.

use glam::Vec3;

/// The settings of a view's picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// Linear RGB radiance that reaches every surface from all directions, from 0. Higher values brighten all
    /// surfaces alike, which makes shadows fainter. They cost nothing. The default is 0.02 in each colour.
    pub ambient: Vec3,
    /// Linear RGB radiance of pixels that show no surface, from 0. The default is black.
    pub background: Vec3,
    /// Factor on radiance before the tonemap, from 0. Higher values brighten the picture. They cost nothing.
    /// The default is 1. A change takes effect with the next
    /// [`Renderer::prepare_output`](super::Renderer::prepare_output).
    pub exposure: f32,
    /// Restricts each light to its depth bounds on the GPU, true by default. The picture is the same without
    /// them, but shadow volumes are then counted at every depth.
    pub depth_bounds: bool,
    /// Restricts each light to its scissor rectangle, true by default. The picture is the same without it,
    /// but each light then costs as much as one that covers the whole view.
    pub scissor: bool,
    /// Draws the shadow geometry of every light over the picture, false by default. It costs one more draw of
    /// that geometry.
    pub debug_volumes: bool,
    /// Prepares the frame for [`Renderer::record_light_count`](super::Renderer::record_light_count) and
    /// [`Renderer::record_planes`](super::Renderer::record_planes), false by default. It costs a pipeline for each kind of
    /// surface, once.
    pub pixel_measures: bool,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            ambient: Vec3::splat(0.02),
            background: Vec3::ZERO,
            exposure: 1.0,
            depth_bounds: true,
            scissor: true,
            debug_volumes: false,
            pixel_measures: false,
        }
    }
}

impl RenderSettings {
    /// Returns the settings with numbers that can be drawn with. Radiance that is negative or not finite
    /// becomes 0. An exposure that is negative or not finite becomes 1.
    pub fn sanitized(&self) -> Self {
        let usable = |x: f32| x.is_finite() && x >= 0.0;
        let radiance = |v: Vec3| Vec3::from_array(v.to_array().map(|x| if usable(x) { x } else { 0.0 }));
        Self {
            ambient: radiance(self.ambient),
            background: radiance(self.background),
            exposure: if usable(self.exposure) { self.exposure } else { 1.0 },
            ..*self
        }
    }
}
