//! The clearcoat of `shaders/common/brdf.wgsl`, on the CPU and in f64.

use glam::DVec3;

/// A light at a point or a sphere of 1 candela, and the coat under it.
pub struct Coat {
    /// Share of the coat, 0 to 1.
    pub clearcoat: f64,
    /// Perceptual roughness.
    pub roughness: f64,
    /// Unit normal.
    pub normal: DVec3,
}

/// Share of the light that the coat keeps from its base.
pub fn share(coat: &Coat, to_eye: DVec3) -> f64 {
    coat.clearcoat * (0.04 + 0.96 * (1.0 - coat.normal.dot(to_eye).abs()).powi(5))
}

/// Radiance of the coat's layer, without its share, by a light of 1 candela and this radius whose centre is at
/// `to_light` from the surface.
pub fn layer(coat: &Coat, to_eye: DVec3, to_light: DVec3, radius: f64) -> f64 {
    let distance = to_light.length();
    let highlight = nearest_to_mirrored(coat, to_eye, to_light, radius).normalize();
    let half = (to_eye + highlight).normalize();
    let alpha = (coat.roughness * coat.roughness).max(1e-3);
    let alpha_sq = alpha * alpha;
    let [n_dot_h, n_dot_l, n_dot_v] = [half, highlight, to_eye].map(|v| coat.normal.dot(v).max(0.0));
    let d = n_dot_h * n_dot_h * (alpha_sq - 1.0) + 1.0;
    let distribution = alpha_sq / (std::f64::consts::PI * d * d);
    let smith = |a: f64, b: f64| a * (b * b * (1.0 - alpha_sq) + alpha_sq).sqrt();
    let visibility = 0.5 / (smith(n_dot_l, n_dot_v) + smith(n_dot_v, n_dot_l));
    let kept = alpha / (alpha + 0.5 * radius / distance).min(1.0);
    distribution * visibility * kept * kept * n_dot_l / (distance * distance)
}

/// The point of a sphere nearest to the ray that a mirror sends to the eye.
fn nearest_to_mirrored(coat: &Coat, to_eye: DVec3, to_light: DVec3, radius: f64) -> DVec3 {
    let mirrored = 2.0 * coat.normal.dot(to_eye) * coat.normal - to_eye;
    let to_ray = mirrored * mirrored.dot(to_light) - to_light;
    to_light + to_ray * (radius / to_ray.length().max(1e-10)).min(1.0)
}
