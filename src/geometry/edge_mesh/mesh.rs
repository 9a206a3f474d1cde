//! [`EdgeMesh`] and its parts.

use std::ops::Range;

use crate::conventions::CLUSTER_TRIANGLES;

/// A triangle mesh with its edges. Built by [`EdgeMesh::build`], then constant; positions are not part of it, so
/// that one mesh serves all poses.
///
/// A triangle is named by its **slot**: cluster · 64 + its place in the cluster, which is its bit in the cluster's
/// facing word. Clusters of closed pieces come first. A **closed** piece is a set of triangles connected over
/// edges, each of whose edges is traversed as often in one direction as in the other.
///
/// A vertex is named by the lowest index among those that weld with it: it reads from the caller's positions,
/// posed or not, and triangles draw from the mesh's own vertex buffer. Corners keep their order, so that a cap
/// rasterises to the very depths of the drawn surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EdgeMesh {
    pub(super) vertex_count: usize,
    pub(super) corners: Vec<[u32; 3]>,
    pub(super) clusters: Vec<Cluster>,
    pub(super) closed_cluster_count: usize,
    pub(super) inner_edges: Vec<InnerEdge>,
    pub(super) seam_sides: Vec<LaneSide>,
    pub(super) seam_slots: Vec<u32>,
    pub(super) seam_clusters: Vec<u32>,
    pub(super) boundary_vertices: Vec<[u32; 2]>,
    pub(super) boundary_slots: Vec<u32>,
    pub(super) irregular_vertices: Vec<[u32; 2]>,
    pub(super) irregular_starts: Vec<u32>,
    pub(super) irregular_sides: Vec<EdgeSide>,
    pub(super) report: EdgeMeshReport,
}

/// Up to [`CLUSTER_TRIANGLES`] neighbouring triangles: one facing word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cluster {
    /// First entry of [`EdgeMesh::corners`].
    pub first_triangle: u32,
    /// 1..=64; short only at the end of the closed and of the open clusters.
    pub triangle_count: u32,
    /// First entry of [`EdgeMesh::inner_edges`]: regular ones between two triangles of this cluster.
    pub first_inner: u32,
    /// Their number.
    pub inner_count: u32,
    /// First entry of [`EdgeMesh::seam_sides`] and [`EdgeMesh::seam_slots`]: regular edges between this cluster and a
    /// later one.
    pub first_seam: u32,
    /// Their number.
    pub seam_count: u32,
    /// First of the later clusters that seams lead to, in [`EdgeMesh::seam_clusters`].
    pub first_seam_cluster: u32,
    /// Their number.
    pub seam_cluster_count: u32,
    /// First of the boundary edges of this cluster's triangles.
    pub first_boundary: u32,
    /// Their number; 0 in closed pieces.
    pub boundary_count: u32,
}

/// A triangle's side, within its cluster: the place of the triangle, and which of its corners the side starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LaneSide(u8);

/// A regular edge between two triangles of one cluster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InnerEdge {
    /// The edge as the triangle of the lower slot traverses it.
    pub side: LaneSide,
    /// Place of the other triangle.
    pub other_lane: u8,
}

impl LaneSide {
    pub(super) fn new(lane: u32, corner: u32) -> Self {
        Self((lane | corner << 6) as u8)
    }

    /// Place of the triangle in its cluster.
    #[inline]
    pub fn lane(self) -> usize {
        (self.0 % CLUSTER_TRIANGLES as u8).into()
    }

    /// The corner that the side starts from: 0, 1 or 2; it ends at the next.
    #[inline]
    pub fn corner(self) -> usize {
        (self.0 / CLUSTER_TRIANGLES as u8).into()
    }

    /// Its vertices, among the corners of its cluster's triangles.
    #[inline]
    pub fn vertices(self, corners: &[[u32; 3]]) -> [u32; 2] {
        let triangle = corners[self.lane()];
        [triangle[self.corner()], triangle[NEXT_CORNER[self.corner()]]]
    }
}

const NEXT_CORNER: [usize; 3] = [1, 2, 0];

/// A triangle at an irregular edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeSide(pub(super) u32);

/// What was left out of an [`EdgeMesh`]. The rest casts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EdgeMeshReport {
    /// Triangles with two corners in one place: they block no light.
    pub collapsed_triangles: usize,
    /// Triangles with a position that is NaN or infinite.
    pub non_finite_triangles: usize,
}

impl EdgeSide {
    pub(super) fn new(slot: u32, reversed: bool) -> Self {
        Self(slot << 1 | u32::from(reversed))
    }

    /// The triangle.
    pub fn slot(self) -> u32 {
        self.0 >> 1
    }

    /// Whether it traverses the edge from its second vertex to its first.
    pub fn is_reversed(self) -> bool {
        self.0 & 1 != 0
    }
}

impl Cluster {
    /// A facing word with all of the cluster's triangles facing.
    pub fn full_word(&self) -> u64 {
        u64::MAX >> (CLUSTER_TRIANGLES as u32 - self.triangle_count)
    }

    /// The cluster's triangles in [`EdgeMesh::corners`].
    pub fn triangles(&self) -> Range<usize> {
        range(self.first_triangle, self.triangle_count)
    }

    /// Its edges in [`EdgeMesh::inner_edges`].
    pub fn inner(&self) -> Range<usize> {
        range(self.first_inner, self.inner_count)
    }

    /// Its edges in [`EdgeMesh::seam_sides`] and [`EdgeMesh::seam_slots`].
    pub fn seams(&self) -> Range<usize> {
        range(self.first_seam, self.seam_count)
    }

    /// Where they lead to, in [`EdgeMesh::seam_clusters`].
    pub fn seam_clusters(&self) -> Range<usize> {
        range(self.first_seam_cluster, self.seam_cluster_count)
    }

    /// Its triangles' edges in [`EdgeMesh::boundary_vertices`].
    pub fn boundary(&self) -> Range<usize> {
        range(self.first_boundary, self.boundary_count)
    }
}

fn range(first: u32, count: u32) -> Range<usize> {
    first as usize..(first + count) as usize
}

impl EdgeMesh {
    /// Positions that the mesh was built from, and that its vertices index.
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Triangles that cast.
    pub fn triangle_count(&self) -> usize {
        self.corners.len()
    }

    /// Those of closed pieces; they come first.
    pub fn closed_triangle_count(&self) -> usize {
        self.clusters[..self.closed_cluster_count]
            .last()
            .map_or(0, |cluster| cluster.triangles().end)
    }

    /// Whether every piece is closed. A mesh without triangles is.
    pub fn is_closed(&self) -> bool {
        self.closed_cluster_count == self.clusters.len()
    }

    /// What was left out.
    pub fn report(&self) -> EdgeMeshReport {
        self.report
    }

    /// Welded vertices of every triangle, cluster after cluster, corners in the order of the input.
    pub fn corners(&self) -> &[[u32; 3]] {
        &self.corners
    }

    /// Clusters, those of closed pieces first.
    pub fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// Number of clusters of closed pieces.
    pub fn closed_cluster_count(&self) -> usize {
        self.closed_cluster_count
    }

    /// Regular edges, of exactly two triangles that traverse them in opposite directions, inside of clusters.
    ///
    /// Edges name a side of a triangle, not vertices: an eighth of the memory, and the corners are read for the caps as
    /// well.
    pub fn inner_edges(&self) -> &[InnerEdge] {
        &self.inner_edges
    }

    /// Regular edges between two clusters, as the triangle in the first of them traverses each.
    pub fn seam_sides(&self) -> &[LaneSide] {
        &self.seam_sides
    }

    /// The slot of the triangle in the second.
    pub fn seam_slots(&self) -> &[u32] {
        &self.seam_slots
    }

    /// For each cluster the later ones that it shares an edge with, ascending.
    pub fn seam_clusters(&self) -> &[u32] {
        &self.seam_clusters
    }

    /// Number of regular edges.
    pub fn regular_count(&self) -> usize {
        self.inner_edges.len() + self.seam_sides.len()
    }

    /// Edges of a single triangle, as that traverses them; always of open pieces.
    pub fn boundary_vertices(&self) -> &[[u32; 2]] {
        &self.boundary_vertices
    }

    /// The slots of their triangles, ascending.
    pub fn boundary_slots(&self) -> &[u32] {
        &self.boundary_slots
    }

    /// Edges that are neither regular nor boundary: of three or more triangles, or of two in one direction.
    pub fn irregular_vertices(&self) -> &[[u32; 2]] {
        &self.irregular_vertices
    }

    /// The triangles of irregular edge `edge`.
    pub fn irregular_sides(&self, edge: usize) -> &[EdgeSide] {
        &self.irregular_sides[self.irregular_starts[edge] as usize..self.irregular_starts[edge + 1] as usize]
    }

    /// Edges of all kinds.
    pub fn edge_count(&self) -> usize {
        self.regular_count() + self.boundary_vertices.len() + self.irregular_vertices.len()
    }

    /// Memory for each triangle, without planes.
    pub fn bytes_per_triangle(&self) -> f64 {
        let bytes = size_of_val(&self.corners[..])
            + size_of_val(&self.clusters[..])
            + size_of_val(&self.inner_edges[..])
            + size_of_val(&self.seam_sides[..])
            + size_of_val(&self.seam_slots[..])
            + size_of_val(&self.seam_clusters[..])
            + size_of_val(&self.boundary_vertices[..])
            + size_of_val(&self.boundary_slots[..])
            + size_of_val(&self.irregular_vertices[..])
            + size_of_val(&self.irregular_starts[..])
            + size_of_val(&self.irregular_sides[..]);
        bytes as f64 / self.corners.len().max(1) as f64
    }
}
