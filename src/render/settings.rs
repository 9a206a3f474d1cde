//! How frames are drawn.

use glam::Vec3;

/// How the frame is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// Linear RGB radiance that reaches every surface from everywhere.
    pub ambient: Vec3,
    /// Linear RGB where nothing is.
    pub background: Vec3,
    /// Factor on radiance before the tonemap.
    pub exposure: f32,
    /// Restricts each light to its depth bounds on the GPU.
    pub depth_bounds: bool,
    /// Restricts each light to its scissor.
    pub scissor: bool,
    /// Draws the shadow geometry of every light over the picture.
    pub debug_volumes: bool,
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
        }
    }
}

impl RenderSettings {
    /// The settings with numbers that can be drawn with: radiance that is not finite or negative counts as 0, such an
    /// exposure as 1.
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
