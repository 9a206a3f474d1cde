//! Occlusion textures on the CPU: the kernel of eq. 4, means over rectangles, slices, and pictures that hold the casters.

mod filters;
mod fit;
mod slices;

use antumbra::geometry::Aabb;
use antumbra::insides::occlusion_textures::{SceneBox, SliceSettings, SlicedKind, SlicedLight};
use glam::{DVec2, DVec3, Vec3};

pub struct Random(fastrand::Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    pub fn unit(&mut self) -> f32 {
        self.0.f32()
    }

    pub fn place(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

pub const SETTINGS: SliceSettings = SliceSettings {
    count: 8,
    weight: 0.0,
    guard: 0.01,
};

/// A light at the origin that shines along −Y.
pub fn light(kind: SlicedKind, half: DVec2) -> SlicedLight {
    SlicedLight {
        origin: DVec3::ZERO,
        axes: [DVec3::X, DVec3::Z, DVec3::NEG_Y],
        half,
        kind,
    }
}

pub fn boxes(count: usize, seed: u64, middle: Vec3) -> Vec<SceneBox> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|_| {
            let center = middle + random.place() * 2.0;
            SceneBox::of_bounds(Aabb::around(center, Vec3::splat(0.1 + 0.3 * random.unit())), true)
        })
        .collect()
}
