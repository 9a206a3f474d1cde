//! The triangles of an occluder, and the edges between them.

use std::collections::HashMap;
use std::sync::{Arc, Weak};

use glam::Vec3;

use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::Aabb;
use crate::geometry::edge_mesh::{EdgeMesh, EdgeMeshInput, LaneSide};
use crate::scene::MeshData;

/// Welded triangles with their edges, in local space. They are exactly the triangles that cast.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OccluderMesh {
    /// Positions of the vertices, each once, metres.
    pub positions: Vec<Vec3>,
    /// Vertices of each triangle. Triangles of closed pieces come first.
    pub triangles: Vec<[u32; 3]>,
    /// Number of triangles that belong to closed pieces.
    pub closed_triangles: usize,
    /// Vertices of each edge.
    pub edges: Vec<[u32; 2]>,
    /// Start of each edge's range in `sides`, and the end of the last range.
    side_starts: Vec<u32>,
    /// Twice the number of a triangle at the edge, plus 1 if the triangle traverses the edge from its second
    /// vertex to its first.
    sides: Vec<u32>,
}

impl OccluderMesh {
    /// The occluder mesh of some data. `None` if the data has no triangles, is no valid mesh, or lies so far
    /// from its origin that a GPU may draw its `f32` vertices elsewhere.
    pub fn build(mesh: &MeshData) -> Option<Self> {
        let edges = EdgeMesh::build(EdgeMeshInput {
            positions: &mesh.positions,
            indices: &mesh.indices,
            pose_keys: None,
            weld_epsilon: None,
        })
        .ok()?;
        if edges.triangle_count() == 0 {
            return None;
        }
        if !is_precise(&mesh.positions) {
            return None;
        }
        let mut numbers = vec![u32::MAX; mesh.positions.len()];
        let mut built = Self {
            closed_triangles: edges.closed_triangle_count(),
            side_starts: vec![0],
            ..Self::default()
        };
        for corners in edges.corners() {
            let triangle = corners.map(|vertex| {
                let number = &mut numbers[vertex as usize];
                if *number == u32::MAX {
                    *number = built.positions.len() as u32;
                    built.positions.push(mesh.positions[vertex as usize]);
                }
                *number
            });
            built.triangles.push(triangle);
        }
        built.place_edges(&edges, &numbers);
        Some(built)
    }

    fn place_edges(&mut self, edges: &EdgeMesh, numbers: &[u32]) {
        let clusters = edges.clusters();
        let triangle_of = |slot: u32| {
            let width = CLUSTER_TRIANGLES as u32;
            clusters[(slot / width) as usize].first_triangle + slot % width
        };
        let mut push = |vertices: [u32; 2], sides: &mut dyn Iterator<Item = u32>| {
            self.edges.push(vertices.map(|vertex| numbers[vertex as usize]));
            self.sides.extend(sides);
            self.side_starts.push(self.sides.len() as u32);
        };
        for cluster in clusters {
            let (first, corners) = (cluster.first_triangle, &edges.corners()[cluster.triangles()]);
            let mut regular = |side: LaneSide, other: u32| {
                let sides = [(first + side.lane() as u32) << 1, other << 1 | 1];
                push(side.vertices(corners), &mut sides.into_iter());
            };
            for edge in &edges.inner_edges()[cluster.inner()] {
                regular(edge.side, first + u32::from(edge.other_lane));
            }
            let seams = cluster.seams();
            for (&side, &slot) in edges.seam_sides()[seams.clone()]
                .iter()
                .zip(&edges.seam_slots()[seams])
            {
                regular(side, triangle_of(slot));
            }
        }
        for (&vertices, &slot) in edges.boundary_vertices().iter().zip(edges.boundary_slots()) {
            push(vertices, &mut std::iter::once(triangle_of(slot) << 1));
        }
        for (edge, &vertices) in edges.irregular_vertices().iter().enumerate() {
            let sides = edges.irregular_sides(edge).iter();
            push(
                vertices,
                &mut sides.map(|side| triangle_of(side.slot()) << 1 | u32::from(side.is_reversed())),
            );
        }
    }

    /// The triangles at an edge, each with whether it traverses the edge backwards.
    pub fn sides(&self, edge: usize) -> impl Iterator<Item = (usize, bool)> + '_ {
        let range = self.side_starts[edge] as usize..self.side_starts[edge + 1] as usize;
        self.sides[range]
            .iter()
            .map(|side| ((side >> 1) as usize, side & 1 != 0))
    }
}

/// Distance from its origin that a mesh may have, in multiples of its size.
const MAX_DISTANCE: f32 = 256.0;

fn is_precise(positions: &[Vec3]) -> bool {
    let bounds = Aabb::from_points(positions.iter().copied());
    let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    !bounds.is_empty() && farthest <= MAX_DISTANCE * bounds.half_size().max_element()
}

/// The occluder meshes in use, by the address of their data. The weak handle distinguishes that data from
/// later data at the same address.
#[derive(Clone, Debug, Default)]
pub struct OccluderMeshes {
    by_address: HashMap<usize, (Weak<MeshData>, Option<Arc<OccluderMesh>>)>,
}

impl OccluderMeshes {
    /// The occluder mesh of some data. It is built on the first call.
    pub fn get_or_build(&mut self, mesh: &Arc<MeshData>) -> Option<Arc<OccluderMesh>> {
        let address = Arc::as_ptr(mesh) as usize;
        if let Some((source, built)) = self.by_address.get(&address)
            && source.upgrade().is_some_and(|source| Arc::ptr_eq(&source, mesh))
        {
            return built.clone();
        }
        self.by_address.retain(|_, (source, _)| source.strong_count() > 0);
        let built = OccluderMesh::build(mesh).map(Arc::new);
        self.by_address
            .insert(address, (Arc::downgrade(mesh), built.clone()));
        built
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_edge_of_a_box_has_two_sides_in_opposite_directions() {
        let mesh = OccluderMesh::build(&MeshData::cuboid(Vec3::ONE)).unwrap();
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (8, 12));
        assert_eq!((mesh.closed_triangles, mesh.edges.len()), (12, 18));
        for (edge, vertices) in mesh.edges.iter().enumerate() {
            let sides: Vec<_> = mesh.sides(edge).collect();
            assert_eq!(sides.len(), 2);
            for (triangle, reversed) in sides {
                let corners = mesh.triangles[triangle];
                let forward = (0..3).any(|i| [corners[i], corners[(i + 1) % 3]] == *vertices);
                assert_eq!(forward, !reversed);
            }
        }
    }

    #[test]
    fn an_open_mesh_has_edges_of_one_side() {
        let mesh = OccluderMesh::build(&MeshData::plane(1.0)).unwrap();
        let single = (0..mesh.edges.len())
            .filter(|&edge| mesh.sides(edge).count() == 1)
            .count();
        assert_eq!((mesh.closed_triangles, single), (0, 4));
    }
}
