//! The shadow volume of one caster in one light.

use glam::Vec4;

/// The shadow volume of one caster in one light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CasterVolume {
    /// Dense index of the caster.
    pub object: u32,
    /// Slot of its silhouette in the light's [`LightSilhouettes`](crate::silhouettes::LightSilhouettes).
    pub slot: u32,
    /// The light as a homogeneous point in the caster's space.
    pub light_local: Vec4,
    /// Factor on the distance from the light, or metres for a light at infinity, by which the far corners are
    /// pushed; 0: to infinity.
    pub extrusion: f32,
    /// True if the volume is counted towards the viewer (depth-pass), false if away from it (depth-fail).
    pub depth_pass: bool,
    /// Whether the sides are drawn.
    pub sides: bool,
    /// Whether the near cap is drawn.
    pub near_cap: bool,
    /// Whether the far cap is drawn.
    pub far_cap: bool,
}
