//! Meshes and lights.

use antumbra::scene::MeshData;
use glam::{Vec3, Vec4};

pub struct Workload {
    pub name: String,
    /// Positions and indices of each mesh.
    pub parts: Vec<(Vec<Vec3>, Vec<u32>)>,
}

/// Joins all parts into one mesh.
pub fn joined(workload: &Workload) -> Workload {
    let (mut all_positions, mut all_indices) = (Vec::new(), Vec::new());
    for (positions, indices) in &workload.parts {
        let first = all_positions.len() as u32;
        all_positions.extend(positions);
        all_indices.extend(indices.iter().map(|index| first + index));
    }
    Workload {
        name: workload.name.replace(" by mesh", ""),
        parts: vec![(all_positions, all_indices)],
    }
}

pub fn icosphere(name: &str, subdivisions: u32) -> Workload {
    let MeshData {
        positions, indices, ..
    } = MeshData::icosphere(1.0, subdivisions);
    Workload {
        name: format!("icosphere {name}"),
        parts: vec![(positions, indices)],
    }
}

/// Returns the mesh with its triangles and vertices in random order.
pub fn shuffled(mesh: &Workload) -> Workload {
    let (positions, indices) = &mesh.parts[0];
    let mut random = Random(1);
    let mut old_from_new: Vec<u32> = (0..positions.len() as u32).collect();
    random.shuffle(&mut old_from_new);
    let mut new_from_old = vec![0; old_from_new.len()];
    for (new, &old) in (0u32..).zip(&old_from_new) {
        new_from_old[old as usize] = new;
    }
    let chunks = indices.as_chunks::<3>().0.iter();
    let mut triangles: Vec<[u32; 3]> = chunks.map(|c| c.map(|i| new_from_old[i as usize])).collect();
    random.shuffle(&mut triangles);
    Workload {
        name: format!("{} shuffled", mesh.name),
        parts: vec![(
            old_from_new.iter().map(|&old| positions[old as usize]).collect(),
            triangles.into_flattened(),
        )],
    }
}

/// Returns 44 point lights on shells around the mesh and four directional lights, in random order.
pub fn lights_around(positions: &[Vec3]) -> Vec<Vec4> {
    let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let (center, radius) = ((low + high) * 0.5, (high - low).length() * 0.5);
    let mut random = Random(2);
    let mut lights: Vec<Vec4> = (0..48)
        .map(|i| {
            // A Fibonacci sphere spreads the directions evenly.
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
            // Knuth's constants (MMIX); the high bits are the most random.
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            values.swap(i, (self.0 >> 33) as usize % (i + 1));
        }
    }
}
