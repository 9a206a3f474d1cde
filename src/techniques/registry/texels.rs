//! The texels of a technique's pictures that a surface is looked up in, for debug views.

use glam::DVec3;

/// A small parallelogram of a surface, such as the part that a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePatch {
    /// Point of the surface, world space, metres.
    pub at: DVec3,
    /// Two sides of the parallelogram, world space, metres.
    pub sides: [DVec3; 2],
}

impl SurfacePatch {
    /// Returns the area of the parallelogram, square metres.
    pub fn area(&self) -> f64 {
        self.sides[0].cross(self.sides[1]).length()
    }
}

/// Returns the number of texels that a patch covers in the picture in which a technique looks it up; `None` where it looks
/// up nothing.
pub type TexelLookup<'w> = Box<dyn Fn(&SurfacePatch) -> Option<f64> + Send + Sync + 'w>;
