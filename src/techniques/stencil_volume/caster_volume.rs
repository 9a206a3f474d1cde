//! Parameters of the shadow volume of one caster in one light.

use glam::Vec4;

use crate::techniques::shared::extrude::TO_INFINITY;

/// The shadow volume of one caster in one light: the parts that are drawn, and how they are counted. Its sides are always
/// drawn; a volume whose sides are out of view is left out as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CasterVolume {
    /// Dense index of the caster in [`Objects`](crate::sets::Objects).
    pub object: u32,
    /// Slot of the caster's silhouette in the light's
    /// [`LightSilhouettes`](crate::silhouettes::LightSilhouettes).
    pub slot: u32,
    /// The light as a homogeneous point in the caster's space.
    pub light_local: Vec4,
    /// Extrusion of the far corners away from the light: a factor on a vertex's distance from the light or,
    /// for a light at infinity, a distance in metres. 0 pushes the corners to infinity.
    pub extrusion: f32,
    /// True if the stencil counts the volume's faces between the viewer and the surface (depth-pass), false
    /// if it counts those behind the surface (depth-fail).
    pub depth_pass: bool,
    /// Whether the near cap of the volume is drawn.
    pub near_cap: bool,
    /// Whether the far cap of the volume is drawn.
    pub far_cap: bool,
}

impl CasterVolume {
    /// Returns the number of corners of a side: three where all far corners are one point, which is so for a directional
    /// light to infinity, and four otherwise.
    pub fn corners_per_edge(&self) -> u32 {
        if self.light_local.w == 0.0 && self.extrusion == TO_INFINITY {
            3
        } else {
            4
        }
    }
}
