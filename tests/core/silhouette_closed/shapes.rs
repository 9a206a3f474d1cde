//! Meshes and lights to try.

use antumbra::geometry::edge_mesh::{EdgeMesh, EdgeMeshInput};
use glam::{Vec3, Vec4};
use proptest::prelude::*;

#[derive(Clone, Debug)]
pub struct Soup {
    pub positions: Vec<Vec3>,
    pub indices: Vec<u32>,
}

impl Soup {
    pub fn build(&self) -> EdgeMesh {
        EdgeMesh::build(EdgeMeshInput {
            positions: &self.positions,
            indices: &self.indices,
            ..EdgeMeshInput::default()
        })
        .unwrap()
    }
}

/// Few places, so that triangles share, repeat, flip, collapse and pile up on edges; −0 among the coordinates.
pub fn soups() -> impl Strategy<Value = Soup> {
    let coordinate = prop::sample::select(vec![-1.0f32, -0.0, 0.0, 1.0, 1.5]);
    let places = prop::collection::vec([coordinate.clone(), coordinate.clone(), coordinate], 3..14);
    places.prop_flat_map(|places| {
        let count = places.len() as u32;
        let triangle = [0..count, 0..count, 0..count];
        prop::collection::vec((triangle, 0..4), 1..150).prop_map(move |triangles| {
            let mut indices = Vec::new();
            for ([a, b, c], again) in triangles {
                indices.extend([a, b, c]);
                match again {
                    0 => indices.extend([c, b, a]), // as a double-sided sheet
                    1 => indices.extend([b, c, a]), // twice
                    _ => {}
                }
            }
            Soup {
                positions: places.iter().map(|&place| Vec3::from(place)).collect(),
                indices,
            }
        })
    })
}

/// Where a light may be, relative to a mesh: see [`light_of`].
pub fn light_seeds() -> impl Strategy<Value = (u8, u32, [f32; 3])> {
    (0..7u8, any::<u32>(), [-3.0..3.0f32, -3.0..3.0f32, -3.0..3.0f32])
}

/// Outside, far, at a vertex, on a triangle, on a triangle's plane beyond it, directional, directional in a plane.
pub fn light_of(positions: &[Vec3], indices: &[u32], (kind, pick, place): (u8, u32, [f32; 3])) -> Vec4 {
    let place = Vec3::from(place);
    let triangle = pick as usize % (indices.len() / 3).max(1);
    let [a, b, c] = [0, 1, 2].map(|k| {
        indices
            .get(triangle * 3 + k)
            .map_or(Vec3::ZERO, |&i| positions[i as usize])
    });
    match kind {
        0 => place.extend(1.0),
        1 => (place * 1e4).extend(1.0),
        2 => a.extend(1.0),
        3 => ((a + b + c) / 3.0).extend(1.0),
        4 => (a + (b - a) * 2.0 + (c - a) * 0.5).extend(1.0),
        5 => place.extend(0.0),
        _ => (b - a).extend(0.0),
    }
}

/// The same triangles in another order, over vertices in another order.
pub fn shuffled(soup: &Soup, seed: u64) -> Soup {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut old_from_new: Vec<u32> = (0..soup.positions.len() as u32).collect();
    random.shuffle(&mut old_from_new);
    let mut new_from_old = vec![0; old_from_new.len()];
    for (new, &old) in (0u32..).zip(&old_from_new) {
        new_from_old[old as usize] = new;
    }
    let mut triangles: Vec<[u32; 3]> = soup
        .indices
        .as_chunks::<3>()
        .0
        .iter()
        .map(|corners| corners.map(|i| new_from_old[i as usize]))
        .collect();
    random.shuffle(&mut triangles);
    Soup {
        positions: old_from_new
            .iter()
            .map(|&old| soup.positions[old as usize])
            .collect(),
        indices: triangles.into_flattened(),
    }
}
