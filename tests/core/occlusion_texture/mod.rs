//! Occlusion textures on the CPU: the kernel of eq. 4, means over rectangles, slices, and pictures that hold the casters.

mod filters;
mod fit;
mod slices;

use antumbra::geometry::Aabb;
use antumbra::insides::occlusion_textures::{SceneBox, SliceSettings, SlicedKind, SlicedLight};
use glam::{DVec2, DVec3, Vec3};

pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
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
    let mut random = Random(seed);
    (0..count)
        .map(|_| {
            let center = middle + random.place() * 2.0;
            SceneBox::of_bounds(Aabb::around(center, Vec3::splat(0.1 + 0.3 * random.unit())), true)
        })
        .collect()
}
