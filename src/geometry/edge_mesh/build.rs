//! Construction of an [`EdgeMesh`] from triangles.

use glam::Vec3;

use super::half_edges::{HalfEdge, edges_of, sorted_half_edges};
use super::mesh::{Cluster, EdgeMesh, EdgeMeshReport, EdgeSide, InnerEdge, LaneSide};
use super::order::{Item, cluster_order};
use super::pieces::closed_triangles;
use super::repeats::without_repeats;
use super::{EdgeMeshError, weld::weld};
use crate::conventions::CLUSTER_TRIANGLES;

/// The input of [`EdgeMesh::build`].
#[derive(Clone, Copy, Debug, Default)]
pub struct EdgeMeshInput<'a> {
    /// All vertices of the mesh, across its submeshes, metres.
    pub positions: &'a [Vec3],
    /// Vertex indices, three for each triangle.
    pub indices: &'a [u32],
    /// One key for each vertex. Vertices with different keys (other joints, weights or morph targets) never
    /// weld, because a pose may separate them.
    pub pose_keys: Option<&'a [u32]>,
    /// Width of a welding cell, metres. `None` welds positions that are bit-exactly equal (−0 is 0). `Some`
    /// welds all vertices in each cube of this width: every one of them moves to the position of the
    /// lowest-numbered, so caps may leave the drawn surface by up to √3 times the width.
    pub weld_epsilon: Option<f32>,
}

impl EdgeMesh {
    /// Welds the vertices, finds the edges and groups the triangles into clusters. O(n log n). The same input
    /// gives the same mesh.
    ///
    /// Triangles that collapse in welding or have a position that is not finite are left out and counted
    /// ([`EdgeMesh::report`]), and so are copies of triangles that are modelled several times in one place, unless
    /// their piece would no longer be closed.
    /// Triangles without area but with distinct corners stay. An input without triangles gives an empty mesh.
    ///
    /// # Errors
    /// [`EdgeMeshError`] if the input is not a mesh.
    pub fn build(input: EdgeMeshInput<'_>) -> Result<Self, EdgeMeshError> {
        validate(&input)?;
        let mut mesh = Self {
            vertex_count: input.positions.len(),
            ..Self::default()
        };
        let (mut triangles, mut report) = welded_triangles(&input);
        let mut half_edges = sorted_half_edges(&triangles);
        if let Some(once) = without_repeats(&triangles, &half_edges) {
            report.repeated_triangles = triangles.len() - once.len();
            half_edges = sorted_half_edges(&once);
            triangles = once;
        }
        mesh.report = report;
        let is_closed = closed_triangles(input.positions, &triangles, &half_edges);
        let slots = mesh.place_triangles(input.positions, &triangles, &is_closed);
        mesh.place_edges(&half_edges, &slots);
        Ok(mesh)
    }

    /// Orders the triangles, closed pieces first, and groups them into clusters. Returns the slot of each
    /// triangle.
    fn place_triangles(
        &mut self,
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        is_closed: &[bool],
    ) -> Vec<u32> {
        let mut slots = vec![0; triangles.len()];
        for closed in [true, false] {
            let mut items: Vec<Item> = (0u32..)
                .zip(triangles)
                .filter(|&(triangle, _)| is_closed[triangle as usize] == closed)
                .map(|(triangle, corners)| sortable(positions, triangle, corners))
                .collect();
            cluster_order(&mut items);
            for cluster in items.chunks(CLUSTER_TRIANGLES) {
                let first_slot = (self.clusters.len() * CLUSTER_TRIANGLES) as u32;
                self.clusters.push(Cluster {
                    first_triangle: self.corners.len() as u32,
                    triangle_count: cluster.len() as u32,
                    first_inner: 0,
                    inner_count: 0,
                    first_seam: 0,
                    seam_count: 0,
                    first_seam_cluster: 0,
                    seam_cluster_count: 0,
                    first_boundary: 0,
                    boundary_count: 0,
                });
                for (slot, item) in (first_slot..).zip(cluster) {
                    slots[item.triangle as usize] = slot;
                    self.corners.push(triangles[item.triangle as usize]);
                }
            }
            if closed {
                self.closed_cluster_count = self.clusters.len();
            }
        }
        slots
    }

    /// Sorts the edges by kind and, within a kind, by the clusters that they lie in.
    fn place_edges(&mut self, half_edges: &[HalfEdge], slots: &[u32]) {
        let slot_of = |half: &HalfEdge| slots[half.triangle() as usize];
        let mut regular = Vec::with_capacity(half_edges.len() / 2);
        let mut boundary = Vec::new();
        let mut irregular = Vec::new();
        for edge in edges_of(half_edges) {
            let vertices = [edge[0].low, edge[0].high];
            match edge {
                [a] => boundary.push((slot_of(a), directed(vertices, a.is_reversed()))),
                [a, b] if a.is_reversed() != b.is_reversed() => {
                    // The lower slot comes first, and the edge runs as that slot's triangle traverses it.
                    let (first, second) = if slot_of(a) < slot_of(b) { (a, b) } else { (b, a) };
                    let vertices = directed(vertices, first.is_reversed());
                    regular.push((slot_of(first), slot_of(second), vertices));
                }
                _ => irregular.push((edge.iter().map(slot_of).min(), edge)),
            }
        }
        // Irregular edges are sorted by slot like boundary edges, so that a light reads the facing words in
        // order.
        irregular.sort_unstable();
        for (_, edge) in irregular {
            self.irregular_vertices.push([edge[0].low, edge[0].high]);
            self.irregular_starts.push(self.irregular_sides.len() as u32);
            let sides = edge
                .iter()
                .map(|half| EdgeSide::new(slot_of(half), half.is_reversed()));
            self.irregular_sides.extend(sides);
        }
        self.irregular_starts.push(self.irregular_sides.len() as u32);
        boundary.sort_unstable();
        for (edge, &(slot, _)) in (0u32..).zip(&boundary) {
            let cluster = &mut self.clusters[slot as usize / CLUSTER_TRIANGLES];
            if cluster.boundary_count == 0 {
                cluster.first_boundary = edge;
            }
            cluster.boundary_count += 1;
        }
        (self.boundary_slots, self.boundary_vertices) = boundary.into_iter().unzip();
        self.place_regular_edges(regular);
    }

    fn place_regular_edges(&mut self, mut regular: Vec<(u32, u32, [u32; 2])>) {
        // Sorts by the cluster of the lower slot. Inner edges and seams are separated below.
        regular.sort_unstable();
        for by_cluster in regular.chunk_by(|a, b| cluster_of(a.0) == cluster_of(b.0)) {
            let first = cluster_of(by_cluster[0].0);
            let cluster = &mut self.clusters[first];
            let corners = &self.corners[cluster.triangles()];
            cluster.first_inner = self.inner_edges.len() as u32;
            cluster.first_seam = self.seam_sides.len() as u32;
            cluster.first_seam_cluster = self.seam_clusters.len() as u32;
            for &(slot_a, slot_b, vertices) in by_cluster {
                let lane = slot_a % CLUSTER_TRIANGLES as u32;
                let start = corners[lane as usize].iter().position(|&v| v == vertices[0]);
                let side = LaneSide::new(lane, start.unwrap_or(0) as u32); // it is an edge of this triangle
                if cluster_of(slot_b) == first {
                    let other_lane = (slot_b % CLUSTER_TRIANGLES as u32) as u8;
                    self.inner_edges.push(InnerEdge { side, other_lane });
                } else {
                    self.seam_sides.push(side);
                    self.seam_slots.push(slot_b);
                }
            }
            cluster.inner_count = self.inner_edges.len() as u32 - cluster.first_inner;
            cluster.seam_count = self.seam_sides.len() as u32 - cluster.first_seam;
            let mut others: Vec<u32> = self.seam_slots[cluster.first_seam as usize..]
                .iter()
                .map(|&slot| cluster_of(slot) as u32)
                .collect();
            others.sort_unstable();
            others.dedup();
            cluster.seam_cluster_count = others.len() as u32;
            self.seam_clusters.extend(others);
        }
    }
}

fn cluster_of(slot: u32) -> usize {
    slot as usize / CLUSTER_TRIANGLES
}

fn validate(input: &EdgeMeshInput<'_>) -> Result<(), EdgeMeshError> {
    let vertex_count = input.positions.len();
    let index_count = input.indices.len();
    // Slots are padded by less than one cluster at the end of the closed part and of the open part.
    if !fits(vertex_count) || !fits(index_count) {
        return Err(EdgeMeshError::TooLarge {
            vertex_count,
            index_count,
        });
    }
    if let Some(keys) = input.pose_keys
        && keys.len() != vertex_count
    {
        return Err(EdgeMeshError::PoseKeyCount {
            key_count: keys.len(),
            vertex_count,
        });
    }
    if let Some(epsilon) = input.weld_epsilon
        && !(epsilon > 0.0 && epsilon.is_finite())
    {
        return Err(EdgeMeshError::WeldEpsilon(epsilon));
    }
    if let Some(corner) = input.indices.iter().position(|&i| i as usize >= vertex_count) {
        return Err(EdgeMeshError::IndexOutOfRange {
            triangle: corner / 3,
            index: input.indices[corner],
            vertex_count,
        });
    }
    if !index_count.is_multiple_of(3) {
        return Err(EdgeMeshError::IncompleteTriangle {
            index_count,
            triangle: index_count / 3,
        });
    }
    Ok(())
}

fn fits(count: usize) -> bool {
    count <= u32::MAX as usize - 2 * CLUSTER_TRIANGLES
}

fn welded_triangles(input: &EdgeMeshInput<'_>) -> (Vec<[u32; 3]>, EdgeMeshReport) {
    let welded = weld(input.positions, input.pose_keys, input.weld_epsilon);
    let mut report = EdgeMeshReport::default();
    let mut triangles = Vec::with_capacity(input.indices.len() / 3);
    for corner in input.indices.chunks_exact(3) {
        let [a, b, c] = [corner[0], corner[1], corner[2]];
        if ![a, b, c].iter().all(|&i| input.positions[i as usize].is_finite()) {
            report.non_finite_triangles += 1;
            continue;
        }
        let [a, b, c] = [a, b, c].map(|i| welded[i as usize]);
        if a == b || b == c || c == a {
            report.collapsed_triangles += 1;
            continue;
        }
        triangles.push([a, b, c]);
    }
    (triangles, report)
}

fn directed([low, high]: [u32; 2], reversed: bool) -> [u32; 2] {
    if reversed { [high, low] } else { [low, high] }
}

fn sortable(positions: &[Vec3], triangle: u32, corners: &[u32; 3]) -> Item {
    let [a, b, c] = corners.map(|i| positions[i as usize]);
    let (ab, ac) = ((b - a).as_dvec3(), (c - a).as_dvec3());
    Item {
        // Divides first, because the sum of finite numbers may overflow.
        centroid: a / 3.0 + b / 3.0 + c / 3.0,
        normal: ab.cross(ac).normalize_or_zero().as_vec3(),
        triangle,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_beyond_32_bits_do_not_fit() {
        assert!(fits(0) && fits(1 << 31));
        assert!(!fits(u32::MAX as usize) && !fits(1 << 40));
    }
}
