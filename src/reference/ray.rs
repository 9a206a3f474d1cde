//! The ray, and its watertight intersection with a triangle.

use glam::DVec3;

/// A half-line. `direction` has any length; parameters along the ray are in units of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start, metres.
    pub origin: DVec3,
    /// Not zero.
    pub direction: DVec3,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Distance in units of the ray's direction.
    pub t: f64,
    /// Triangle of the [`RayScene`](super::RayScene).
    pub triangle: u32,
    /// Weights of the triangle's corners; each ≥ 0, sum 1.
    pub barycentric: DVec3,
}

/// A ray made ready for many triangles: the axes permuted so that the direction is longest along the third,
/// and the shear that takes the direction onto that axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearedRay {
    origin: DVec3,
    axes: [usize; 3],
    shear: DVec3,
}

impl ShearedRay {
    /// Shears `ray`. A direction that is zero or not finite gives a ray that hits nothing.
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

    /// Parameter and barycentric weights of the crossing with a triangle, from either side.
    ///
    /// Watertight: a ray that passes between two triangles with a common edge, or through the fan round a common
    /// corner, hits at least one. Each corner is sheared alone, so triangles that share it see the same 2D
    /// point; an edge function is the difference of two rounded products, rounding is monotonic, so its sign is
    /// right or it is zero, and zero counts as inside. A triangle seen exactly edge-on is not hit; its
    /// neighbours across those edges are.
    ///
    /// Source: Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection", with `f64` throughout: the
    /// original's fallback to double precision for zeros is thus its main path, and zeros stay hits.
    pub fn intersect(&self, corners: &[DVec3; 3]) -> Option<(f64, DVec3)> {
        let [a, b, c] = corners.map(|corner| {
            let p = corner - self.origin;
            let [x, y, z] = self.axes.map(|axis| p[axis]);
            DVec3::new(x - self.shear.x * z, y - self.shear.y * z, self.shear.z * z)
        });
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
}
