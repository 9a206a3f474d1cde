//! The ray, and its watertight intersection with a triangle.

use glam::DVec3;

/// A half-line. Parameters along the ray are in units of the length of `direction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start of the ray, metres.
    pub origin: DVec3,
    /// Direction of the ray. It may have any length except zero.
    pub direction: DVec3,
}

/// The point where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Distance from the ray's origin, in units of the length of its direction.
    pub t: f64,
    /// Index of the triangle in its [`RayScene`](super::RayScene).
    pub triangle: u32,
    /// Barycentric weights of the triangle's corners. Each is ≥ 0; their sum is 1.
    pub barycentric: DVec3,
}

/// A ray prepared for intersection with many triangles. The axes are permuted so that the direction is
/// longest along the third, and a shear takes the direction onto that axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearedRay {
    origin: DVec3,
    axes: [usize; 3],
    shear: DVec3,
}

impl ShearedRay {
    /// Prepares `ray`. A direction that is zero or not finite gives a ray that hits nothing.
    pub fn new(ray: &Ray) -> Self {
        let last = ray.direction.abs().max_position();
        let axes = [(last + 1) % 3, (last + 2) % 3, last];
        let [x, y, z] = axes.map(|axis| ray.direction[axis]);
        Self {
            origin: ray.origin,
            axes,
            shear: DVec3::new(x / z, y / z, 1.0 / z),
        }
    }

    /// Parameter and barycentric weights of the ray's intersection with a triangle, from either side.
    ///
    /// The test is watertight: a ray that passes between two triangles with a common edge, or through the fan
    /// around a common corner, hits at least one of them. Each corner is sheared separately, so triangles
    /// that share it compute the same 2D point. An edge function is the difference of two rounded products,
    /// and rounding is monotonic, so its sign is either right or zero; zero counts as inside. A triangle seen
    /// exactly edge-on is not hit; its neighbours across those edges are.
    ///
    /// Source: Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection", in `f64` throughout. The
    /// original's fallback to double precision for zeros is thus the main path, and zeros remain hits.
    pub fn intersect(&self, corners: &[DVec3; 3]) -> Option<(f64, DVec3)> {
        let [a, b, c] = corners;
        let (a, b, c) = (self.sheared(*a), self.sheared(*b), self.sheared(*c));
        let edges = DVec3::new(
            c.x * b.y - c.y * b.x,
            a.x * c.y - a.y * c.x,
            b.x * a.y - b.y * a.x,
        );
        let determinant = edges.element_sum();
        let inside = edges.cmpge(DVec3::ZERO).all() || edges.cmple(DVec3::ZERO).all();
        if !inside || determinant == 0.0 {
            return None;
        }
        let barycentric = edges / determinant;
        let t = barycentric.dot(DVec3::new(a.z, b.z, c.z));
        (t.is_finite() && barycentric.is_finite()).then_some((t, barycentric))
    }
    /// A point in the ray's own space: its origin is the ray's, and the ray runs along the third axis.
    fn sheared(&self, point: DVec3) -> DVec3 {
        let p = point - self.origin;
        let [along_x, along_y, along_z] = self.axes;
        let (x, y, z) = (p[along_x], p[along_y], p[along_z]);
        DVec3::new(x - self.shear.x * z, y - self.shear.y * z, self.shear.z * z)
    }
}
