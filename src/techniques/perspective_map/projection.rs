//! The viewer's projection, slid back; and the light in its space, the post-projective space.
//!
//! With `near` and `far` the depths of what is seen, the projection maps them to −1 and 1, and x and y to
//! −1 … 1 as well: the unit cube. The virtual viewer stands `slide` behind the eye and has its near plane on
//! the eye's (§14.2.1), so w is 1 + κ (depth − near) with κ = 1 / (near + slide). κ is 0 for an infinite
//! slide: the projection is then affine, and the map a uniform one.

use glam::{DMat4, DVec3, DVec4};

/// A projection of view coordinates ([`ViewSpace`](super::view_space::ViewSpace)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Nearest depth of what is seen.
    pub near: f64,
    /// Farthest depth of what is seen.
    pub far: f64,
    /// Growth of w with depth; 0: the projection is affine.
    pub growth: f64,
    /// Matrix from view coordinates.
    pub matrix: DMat4,
}

/// A light in post-projective space: a homogeneous point that may lie at infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectedLight {
    /// Its first three coordinates.
    pub point: DVec3,
    /// Its w, at least 0; 0: the light is at infinity there. That is so for a light in the plane of the
    /// virtual eye.
    pub w: f64,
}

impl Projection {
    /// Makes the projection between two depths, `near < far`.
    pub fn new(near: f64, far: f64, growth: f64, is_perspective: bool) -> Self {
        let length = far - near;
        let far_w = 1.0 + growth * length;
        // Places of the screen's border are at |x| = depth, in an orthographic view at |x| = 1.
        let half = if is_perspective {
            near.max(far / far_w)
        } else {
            1.0
        };
        let scale = half.recip();
        // Depth `near` has w = 1 and z = −1, depth `far` has z = w.
        let slope = (far_w + 1.0) / length;
        let matrix = DMat4::from_cols(
            DVec4::X * scale,
            DVec4::Y * scale,
            DVec4::new(0.0, 0.0, slope, growth),
            DVec4::new(0.0, 0.0, -1.0 - slope * near, 1.0 - growth * near),
        );
        Self {
            near,
            far,
            growth,
            matrix,
        }
    }

    /// Distance by which the virtual viewer stands behind the eye, metres; infinite for an affine projection.
    pub fn slide(&self) -> f64 {
        (self.growth.recip() - self.near).max(0.0)
    }

    /// Projects a point of view coordinates. Its depth is at least `near`.
    pub fn point(&self, view: DVec3) -> DVec3 {
        let projected = self.matrix * view.extend(1.0);
        projected.truncate() / projected.w
    }

    /// Projects a light, given as a homogeneous point of view coordinates.
    pub fn light(&self, view: DVec4) -> ProjectedLight {
        let projected = self.matrix * view;
        // A homogeneous point and its negative are one place. In a camera's rows the sign cancels.
        let sign = if projected.w < 0.0 { -1.0 } else { 1.0 };
        // Lengths near 1 keep what follows in the range of numbers.
        let scale = sign / projected.length().max(f64::MIN_POSITIVE);
        ProjectedLight {
            point: projected.truncate() * scale,
            w: projected.w * scale,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The order along a ray of light that passes behind the viewer: the depth that the source's inverse projection
    /// writes, `½ (1 + a / z)`, rises along it, with z the distance from the light's place in post-projective space.
    #[test]
    fn the_inverse_projection_keeps_the_order_of_a_ray_past_infinity() {
        let projection = Projection::new(1.0, 100.0, 1.0, true);
        let towards = DVec4::new(0.1, 0.8, -0.6, 0.0); // the light is behind and above
        let light = projection.matrix * towards;
        let place = light.truncate() / light.w;
        let hit = DVec3::new(0.0, -1.0, 5.0);
        let mut last = f64::MIN;
        let mut behind = 0;
        for i in 0..200 {
            let point = hit + towards.truncate() * (20.0 - 0.1 * f64::from(i));
            let projected = projection.matrix * point.extend(1.0);
            behind += usize::from(projected.w < 0.0);
            // The signed distance along the light camera's axis: negative behind the viewer.
            let axis = (projection.point(hit) - place).normalize();
            let z = (projected.truncate() / projected.w - place).dot(axis);
            let depth = 0.5 * (1.0 + 0.01 / z);
            assert!(depth > last, "{i}: {depth} after {last}");
            last = depth;
        }
        assert!(behind > 20 && behind < 180, "{behind}");
    }

    #[test]
    fn the_corners_of_the_view_are_those_of_the_unit_cube() {
        for (growth, tight) in [(0.5, true), (0.1, false), (0.0, false)] {
            let projection = Projection::new(2.0, 50.0, growth, true);
            let near = projection.point(DVec3::new(2.0, -2.0, 2.0));
            let far = projection.point(DVec3::new(50.0, 50.0, 50.0));
            assert!((near.z + 1.0).abs() < 1e-12 && (far.z - 1.0).abs() < 1e-12);
            assert!(near.abs().max_element() < 1.0 + 1e-12 && far.abs().max_element() < 1.0 + 1e-12);
            assert_eq!(
                near.x > 1.0 - 1e-9,
                tight,
                "both ends fill the cube without a slide alone"
            );
            assert!((far.x - 1.0).abs() < 1e-12);
        }
        // A directional light is at Q of the source, 2 Q − 1 in a cube from −1 to 1, when nothing is slid.
        let projection = Projection::new(1.0, 4000.0, 1.0, true);
        let light = projection.light(DVec4::new(0.0, 0.0, 1.0, 0.0));
        let q = 4000.0 / 3999.0;
        assert!((light.point.z / light.w - (2.0 * q - 1.0)).abs() < 1e-12);
    }
}
