//! The volume of one caster in one light.

use glam::Vec4;

/// Which parts of one caster's volume in one light are drawn, and how they are counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CasterVolume {
    /// Dense index of the caster.
    pub object: u32,
    /// Slot of its silhouette in the light's [`LightSilhouettes`](crate::silhouettes::LightSilhouettes).
    pub slot: u32,
    /// The light in the caster's space.
    pub light_local: Vec4,
    /// See [`far_position`](crate::techniques::shared::extrude::far_position).
    pub extrusion: f32,
    /// Counted towards the viewer (depth-pass); else away from it (depth-fail).
    pub depth_pass: bool,
    /// The sides are drawn.
    pub sides: bool,
    /// The near cap is drawn.
    pub near_cap: bool,
    /// The far cap is drawn.
    pub far_cap: bool,
}
