//! Triangles that cut a light, the patches that they form, and the polygons that stand for them.

use glam::DVec3;

/// A triangle that cuts the light, in light space.
#[derive(Clone, Copy, Debug)]
pub struct CutTriangle {
    /// The triangle's slot in its mesh.
    pub slot: u32,
    /// Vertices of the mesh.
    pub vertices: [u32; 3],
    /// Positions of the vertices in light space.
    pub corners: [DVec3; 3],
    /// Distance from the light's centre, metres.
    pub distance: f64,
}

impl CutTriangle {
    /// Returns a vector along the normal, twice as long as the area.
    pub(super) fn normal(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a)
    }
}

/// A part of the surface that is nearly flat.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Slot of the triangle nearest to the light.
    pub slot: u32,
    /// Unit normal by the winding of the triangles.
    pub normal: DVec3,
    /// The plane holds the points with `dot(normal, p) + offset == 0`.
    pub offset: f64,
    /// Greatest distance of a vertex from the plane, metres.
    pub tolerance: f64,
    /// Whether the patch lies beyond the light's extent, so its outline acts as penumbra edges.
    pub is_level: bool,
}

/// A polygon that stands for a part of a patch. It may cross itself: its area counts with its sign.
#[derive(Clone, Copy, Debug)]
pub struct CutPolygon {
    /// Corners in light space; a triangle repeats its last one.
    pub corners: [DVec3; 4],
    /// Index of its [`Patch`].
    pub patch: u32,
}

/// No patch, or no triangle.
pub(super) const NONE: u32 = u32::MAX;

/// Returns the vertices of a triangle's side, in its direction.
pub(super) fn side_of(vertices: [u32; 3], corner: usize) -> [u32; 2] {
    [vertices[corner], vertices[(corner + 1) % 3]]
}
