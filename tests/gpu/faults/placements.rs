//! Random places on, above and below surfaces.

use glam::DVec3;

/// Random numbers from a seed.
pub struct Random(fastrand::Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    /// Returns a number from 0 to less than 1.
    pub fn unit(&mut self) -> f64 {
        self.0.f64()
    }

    /// Returns a point of a cube around the origin.
    pub fn point(&mut self, half: f64) -> DVec3 {
        DVec3::new(self.unit() - 0.5, self.unit() - 0.5, self.unit() - 0.5) * (2.0 * half)
    }
}

/// Returns a place at a height over a corner, an edge or the inside of a triangle, rounded as a component holds it.
pub fn on_triangle(random: &mut Random, corners: [DVec3; 3], height: f64) -> DVec3 {
    let [a, b, c] = corners;
    let (mut u, mut v) = (random.unit(), random.unit());
    match (random.unit() * 6.0) as u32 {
        0 => (u, v) = (0.0, 0.0),
        1 => v = 0.0,
        2 => (u, v) = (0.5, 0.5),
        _ if u + v > 1.0 => (u, v) = (1.0 - u, 1.0 - v),
        _ => {}
    }
    let normal = (b - a).cross(c - a).normalize();
    (a + (b - a) * u + (c - a) * v + normal * height)
        .as_vec3()
        .as_dvec3()
}
