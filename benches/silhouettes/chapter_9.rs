//! The baseline: silhouettes of closed meshes as in GPU Gems chapter 9.
//!
//! Source: McGuire 2004, "Efficient Shadow Volume Rendering", listings 9-5 to 9-7. Face normals and edges are
//! prepared as section 9.2.2 asks. Edges that do not have exactly two faces are left out, because the chapter cannot
//! use them.

use antumbra::geometry::edge_mesh::EdgeMesh;
use glam::{Vec3, Vec4};

struct Face {
    vertices: [u32; 3],
    normal: Vec3,
}

struct Edge {
    vertices: [u32; 2],
    faces: [u32; 2],
}

pub struct ChapterMesh {
    faces: Vec<Face>,
    edges: Vec<Edge>,
}

#[derive(Default)]
pub struct ChapterVolume {
    backface: Vec<bool>,
    pub caps: Vec<u32>,
    pub sides: Vec<u32>,
}

impl ChapterMesh {
    /// Builds the mesh from triangles in the order of the input. The edge mesh is used only for its welding.
    pub fn new(positions: &[Vec3], indices: &[u32], welded: &EdgeMesh) -> Self {
        let mut ids: Vec<(u128, u32)> = Vec::with_capacity(positions.len());
        let bits = |p: Vec3| {
            p.to_array()
                .iter()
                .fold(0, |key, x| key << 32 | u128::from((x + 0.0).to_bits()))
        };
        ids.extend((0u32..).zip(positions).map(|(vertex, &p)| (bits(p), vertex)));
        ids.sort_unstable();
        let id = |vertex: u32| {
            let key = bits(positions[vertex as usize]);
            ids[ids.partition_point(|&(other, _)| other < key)].1
        };
        let faces: Vec<Face> = indices
            .as_chunks::<3>()
            .0
            .iter()
            .map(|corners| {
                let vertices = corners.map(id);
                let [a, b, c] = vertices.map(|i| positions[i as usize]);
                Face {
                    vertices,
                    normal: (b - a).cross(c - a),
                }
            })
            .collect();
        let mut halves: Vec<([u32; 2], bool, u32)> = Vec::with_capacity(indices.len());
        for (
            face,
            Face {
                vertices: [a, b, c], ..
            },
        ) in (0u32..).zip(&faces)
        {
            for (a, b) in [(a, b), (b, c), (c, a)] {
                halves.push(([*a.min(b), *a.max(b)], a > b, face));
            }
        }
        halves.sort_unstable();
        let mut edges: Vec<Edge> = halves
            .chunk_by(|a, b| a.0 == b.0)
            .filter_map(|edge| match edge {
                &[(vertices, false, first), (_, true, second)] => Some(Edge {
                    vertices,
                    faces: [first, second],
                }),
                _ => None,
            })
            .collect();
        // In the order in which a loop over the faces would meet them.
        edges.sort_unstable_by_key(|edge| edge.faces[0].min(edge.faces[1]));
        let is_manifold = welded.is_closed() && welded.irregular_vertices().is_empty();
        assert!(!is_manifold || edges.len() * 2 == welded.triangle_count() * 3);
        Self { faces, edges }
    }

    pub fn mark_shadows(&self, positions: &[Vec3], light_local: Vec4, volume: &mut ChapterVolume) {
        let vertex_count = positions.len() as u32;
        let ChapterVolume {
            backface,
            caps,
            sides,
        } = volume;
        backface.resize(self.faces.len(), false);
        for (is_back, face) in backface.iter_mut().zip(&self.faces) {
            let towards = light_local.truncate() - positions[face.vertices[0] as usize] * light_local.w;
            *is_back = face.normal.dot(towards) < 0.0;
        }
        caps.clear();
        for (&is_back, face) in backface.iter().zip(&self.faces) {
            for vertex in face.vertices {
                caps.push(if is_back { vertex + vertex_count } else { vertex });
            }
        }
        sides.clear();
        for edge in &self.edges {
            if backface[edge.faces[0] as usize] != backface[edge.faces[1] as usize] {
                let [v0, v1] = edge.vertices;
                let (v0, v1) = if backface[edge.faces[0] as usize] {
                    (v0, v1)
                } else {
                    (v1, v0)
                };
                sides.extend([v0, v1, v1 + vertex_count, v0 + vertex_count]);
            }
        }
    }
}
