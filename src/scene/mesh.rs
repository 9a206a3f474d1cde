//! Triangle meshes on the CPU.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Vec2, Vec3, Vec4};

/// An indexed triangle mesh in local space: several submeshes, one for each material, over shared vertices.
/// Every vertex stream has one entry for each vertex, unless its description says that it may be empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Name of the mesh, used in messages.
    pub name: String,
    /// Position of each vertex, metres.
    pub positions: Vec<Vec3>,
    /// Unit normal of each vertex.
    pub normals: Vec<Vec3>,
    /// Unit tangent of each vertex, and in `w` the sign of the bitangent. `w = 0` where a vertex has no
    /// tangent. May be empty.
    pub tangents: Vec<Vec4>,
    /// First set of texture coordinates. May be empty.
    pub uv0: Vec<Vec2>,
    /// Second set of texture coordinates. May be empty.
    pub uv1: Vec<Vec2>,
    /// Vertex colours: linear RGBA that multiplies the base colour. May be empty.
    pub colors: Vec<Vec4>,
    /// Vertex indices, three for each triangle, each below `positions.len()`.
    pub indices: Vec<u32>,
    /// Ranges of `indices`, one for each material.
    pub submeshes: Vec<Submesh>,
    /// Four joints for each vertex, as indices into [`Skin::joints`](super::Skin::joints). Empty if the mesh
    /// is not skinned.
    pub joints: Vec<[u16; 4]>,
    /// Weights of the four joints of each vertex; their sum is 1. Empty if the mesh is not skinned.
    pub joint_weights: Vec<Vec4>,
    /// Morph targets of the mesh. [`MorphWeights`](super::MorphWeights) weights them.
    pub morph_targets: Vec<MorphTarget>,
}

/// A part of a mesh that has one material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Submesh {
    /// Index of the submesh's first entry in [`MeshData::indices`].
    pub first_index: u32,
    /// Number of indices, a multiple of three.
    pub index_count: u32,
}

/// The offsets that a morph target adds to each vertex at weight 1. A stream is either empty or has one entry
/// for each vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// Offsets added to positions, metres.
    pub positions: Vec<Vec3>,
    /// Offsets added to normals.
    pub normals: Vec<Vec3>,
    /// Offsets added to tangents.
    pub tangents: Vec<Vec3>,
}

/// The mesh of an entity. It is drawn if the entity also has [`SceneMaterials`](super::SceneMaterials).
#[derive(Component, Clone, Debug)]
#[require(Transform)]
#[require(super::LocalBounds)]
#[require(super::WorldBounds)]
#[require(super::SelectionLayers)]
pub struct SceneMesh(pub Arc<MeshData>);

impl MeshData {
    /// Number of triangles in the mesh.
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// The range of [`MeshData::indices`] that a submesh draws: whole triangles, cut to the indices that
    /// exist.
    pub fn submesh_range(&self, submesh: &Submesh) -> std::ops::Range<usize> {
        let first = (submesh.first_index as usize).min(self.indices.len());
        let count = (submesh.index_count as usize).min(self.indices.len() - first);
        first..first + count - count % 3
    }

    /// A mesh with a single submesh, from positions and indices. Its normals are smooth (area-weighted).
    pub fn from_triangles(name: &str, positions: Vec<Vec3>, indices: Vec<u32>) -> Self {
        let mut normals = vec![Vec3::ZERO; positions.len()];
        for corner in indices.chunks_exact(3) {
            let [a, b, c] = [corner[0], corner[1], corner[2]].map(|i| positions[i as usize]);
            let weighted = (b - a).cross(c - a);
            for &i in corner {
                normals[i as usize] += weighted;
            }
        }
        for normal in &mut normals {
            *normal = normal.normalize_or(Vec3::Y);
        }
        Self {
            name: name.to_owned(),
            submeshes: vec![Submesh {
                first_index: 0,
                index_count: indices.len() as u32,
            }],
            positions,
            normals,
            indices,
            ..Self::default()
        }
    }

    /// An axis-aligned box around the origin with flat normals, wound outward.
    pub fn cuboid(half_size: Vec3) -> Self {
        let mut mesh = Self {
            name: "cuboid".to_owned(),
            ..Self::default()
        };
        for axis in 0..3 {
            for sign in [-1.0f32, 1.0] {
                let mut normal = Vec3::ZERO;
                normal[axis] = sign;
                let mut u = Vec3::ZERO;
                u[(axis + 1) % 3] = 1.0;
                let v = normal.cross(u);
                let base = mesh.positions.len() as u32;
                for (su, sv) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                    mesh.positions.push((normal + u * su + v * sv) * half_size);
                    mesh.normals.push(normal);
                }
                mesh.indices
                    .extend([0, 1, 2, 0, 2, 3].map(|corner| base + corner));
            }
        }
        mesh.submeshes = vec![Submesh {
            first_index: 0,
            index_count: mesh.indices.len() as u32,
        }];
        mesh
    }

    /// A horizontal square around the origin that faces +Y.
    pub fn plane(half_size: f32) -> Self {
        let h = half_size;
        Self::from_triangles(
            "plane",
            vec![
                Vec3::new(-h, 0.0, -h),
                Vec3::new(-h, 0.0, h),
                Vec3::new(h, 0.0, h),
                Vec3::new(h, 0.0, -h),
            ],
            vec![0, 1, 2, 0, 2, 3],
        )
    }

    /// A sphere of `20 · 4^subdivisions` triangles around the origin with smooth normals, wound outward.
    pub fn icosphere(radius: f32, subdivisions: u32) -> Self {
        let phi = (1.0 + 5.0f32.sqrt()) * 0.5;
        let mut positions: Vec<Vec3> = [
            (-1.0, phi, 0.0),
            (1.0, phi, 0.0),
            (-1.0, -phi, 0.0),
            (1.0, -phi, 0.0),
            (0.0, -1.0, phi),
            (0.0, 1.0, phi),
            (0.0, -1.0, -phi),
            (0.0, 1.0, -phi),
            (phi, 0.0, -1.0),
            (phi, 0.0, 1.0),
            (-phi, 0.0, -1.0),
            (-phi, 0.0, 1.0),
        ]
        .map(|(x, y, z)| Vec3::new(x, y, z).normalize())
        .to_vec();
        let mut triangles: Vec<[u32; 3]> = vec![
            [0, 11, 5],
            [0, 5, 1],
            [0, 1, 7],
            [0, 7, 10],
            [0, 10, 11],
            [1, 5, 9],
            [5, 11, 4],
            [11, 10, 2],
            [10, 7, 6],
            [7, 1, 8],
            [3, 9, 4],
            [3, 4, 2],
            [3, 2, 6],
            [3, 6, 8],
            [3, 8, 9],
            [4, 9, 5],
            [2, 4, 11],
            [6, 2, 10],
            [8, 6, 7],
            [9, 8, 1],
        ];
        for _ in 0..subdivisions {
            let mut middles = std::collections::HashMap::new();
            let mut middle = |a: u32, b: u32, positions: &mut Vec<Vec3>| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    positions.push((positions[a as usize] + positions[b as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            triangles = triangles
                .iter()
                .flat_map(|&[a, b, c]| {
                    let ab = middle(a, b, &mut positions);
                    let bc = middle(b, c, &mut positions);
                    let ca = middle(c, a, &mut positions);
                    [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
                })
                .collect();
        }
        let normals = positions.clone();
        let mut mesh = Self::from_triangles(
            "icosphere",
            positions.iter().map(|&p| p * radius).collect(),
            triangles.into_flattened(),
        );
        mesh.normals = normals;
        mesh
    }
}
