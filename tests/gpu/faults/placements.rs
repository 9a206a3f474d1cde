//! Random places on, above and below surfaces.

use glam::DVec3;

/// SplitMix64.
pub struct Random(pub u64);

impl Random {
    /// Returns a number from 0 to less than 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
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
