//! Meshes and lights.

use antumbra::scene::MeshData;
use glam::{Vec3, Vec4};

pub struct Workload {
    pub name: String,
    pub positions: Vec<Vec3>,
    pub indices: Vec<u32>,
}

pub fn icosphere(name: &str, subdivisions: u32) -> Workload {
    let MeshData {
        positions, indices, ..
    } = MeshData::icosphere(1.0, subdivisions);
    Workload {
        name: format!("icosphere {name}"),
        positions,
        indices,
    }
}

/// The same triangles in random order, over vertices in random order.
pub fn shuffled(mesh: &Workload) -> Workload {
    let mut random = Random(1);
    let mut old_from_new: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    random.shuffle(&mut old_from_new);
    let mut new_from_old = vec![0; old_from_new.len()];
    for (new, &old) in (0u32..).zip(&old_from_new) {
        new_from_old[old as usize] = new;
    }
    let chunks = mesh.indices.as_chunks::<3>().0.iter();
    let mut triangles: Vec<[u32; 3]> = chunks.map(|c| c.map(|i| new_from_old[i as usize])).collect();
    random.shuffle(&mut triangles);
    Workload {
        name: format!("{} shuffled", mesh.name),
        positions: old_from_new
            .iter()
            .map(|&old| mesh.positions[old as usize])
            .collect(),
        indices: triangles.into_flattened(),
    }
}

/// 44 point lights on shells around the mesh and four directional ones, in random order.
pub fn lights_around(positions: &[Vec3]) -> Vec<Vec4> {
    let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let (center, radius) = ((low + high) * 0.5, (high - low).length() * 0.5);
    let mut random = Random(2);
    let mut lights: Vec<Vec4> = (0..48)
        .map(|i| {
            // A Fibonacci sphere: directions spread evenly.
            let y = 1.0 - (i as f32 + 0.5) / 24.0;
            let (sin, cos) = (i as f32 * 2.399_963_2).sin_cos();
            let around = (1.0 - y * y).sqrt();
            let direction = Vec3::new(around * cos, y, around * sin);
            match i % 12 {
                11 => direction.extend(0.0),
                shell => (center + direction * radius * [1.2, 2.0, 4.0, 16.0][shell % 4]).extend(1.0),
            }
        })
        .collect();
    random.shuffle(&mut lights);
    lights
}

struct Random(u64);

impl Random {
    fn shuffle<T>(&mut self, values: &mut [T]) {
        for i in (1..values.len()).rev() {
            // Knuth's constants, MMIX; the high bits are the good ones.
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            values.swap(i, (self.0 >> 33) as usize % (i + 1));
        }
    }
}
