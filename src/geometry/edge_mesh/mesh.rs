//! The edge mesh and its parts.

use std::ops::Range;

use crate::conventions::CLUSTER_TRIANGLES;

/// A triangle mesh with its edges. It is built by [`EdgeMesh::build`] and then constant. It holds no
/// positions, so one mesh serves all poses.
///
/// A triangle is named by its **slot**: cluster · 64 + its place in the cluster, which is also its bit in the
/// cluster's facing word. Clusters of closed pieces come first. A **closed** piece is a set of triangles
/// connected over edges, with a positive volume, each of whose edges is traversed as often in one direction
/// as in the other.
///
/// A vertex is named by the lowest index among the vertices that weld with it. That index reads from the
/// caller's positions, posed or not, and triangles draw from the mesh's own vertex buffer. Corners keep their
/// order, so that a cap rasterises to exactly the depths of the drawn surface.
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

/// Up to [`CLUSTER_TRIANGLES`] neighbouring triangles, whose facing bits share one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cluster {
    /// Index of the cluster's first triangle in [`EdgeMesh::corners`].
    pub first_triangle: u32,
    /// Number of triangles, 1..=64. It is below 64 only in the last closed and in the last open cluster.
    pub triangle_count: u32,
    /// Index of the cluster's first edge in [`EdgeMesh::inner_edges`]: regular edges between two triangles of
    /// this cluster.
    pub first_inner: u32,
    /// Number of the cluster's inner edges.
    pub inner_count: u32,
    /// Index of the cluster's first seam in [`EdgeMesh::seam_sides`] and [`EdgeMesh::seam_slots`]. A seam is
    /// a regular edge between this cluster and a later one.
    pub first_seam: u32,
    /// Number of the cluster's seams.
    pub seam_count: u32,
    /// Index in [`EdgeMesh::seam_clusters`] of the first later cluster that a seam leads to.
    pub first_seam_cluster: u32,
    /// Number of later clusters that seams lead to.
    pub seam_cluster_count: u32,
    /// Index in [`EdgeMesh::boundary_vertices`] of the first boundary edge of this cluster's triangles.
    pub first_boundary: u32,
    /// Number of boundary edges of this cluster's triangles; 0 in closed pieces.
    pub boundary_count: u32,
}

/// A side of a triangle within its cluster: the triangle's place, and the corner that the side starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LaneSide(u8);

/// A regular edge between two triangles of one cluster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InnerEdge {
    /// The edge, as a side of the triangle in the lower slot.
    pub side: LaneSide,
    /// Place of the other triangle in the cluster.
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

    /// The corner that the side starts from: 0, 1 or 2. The side ends at the next corner.
    #[inline]
    pub fn corner(self) -> usize {
        (self.0 / CLUSTER_TRIANGLES as u8).into()
    }

    /// The two vertices of the side. `corners` are the corners of the cluster's triangles.
    #[inline]
    pub fn vertices(self, corners: &[[u32; 3]]) -> [u32; 2] {
        let triangle = corners[self.lane()];
        [triangle[self.corner()], triangle[NEXT_CORNER[self.corner()]]]
    }
}

const NEXT_CORNER: [usize; 3] = [1, 2, 0];

/// One of the triangles at an irregular edge, and the direction in which it traverses the edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeSide(pub(super) u32);

/// Counts of triangles that were left out of an [`EdgeMesh`]. All other triangles cast.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EdgeMeshReport {
    /// Triangles with two corners in one place. They block no light.
    pub collapsed_triangles: usize,
    /// Triangles with a position that is NaN or infinite.
    pub non_finite_triangles: usize,
    /// Triangles that are there already, in the same place. They cast no shadow of their own.
    pub repeated_triangles: usize,
}

impl EdgeSide {
    pub(super) fn new(slot: u32, reversed: bool) -> Self {
        Self(slot << 1 | u32::from(reversed))
    }

    /// Slot of the triangle.
    pub fn slot(self) -> u32 {
        self.0 >> 1
    }

    /// Whether the triangle traverses the edge from its second vertex to its first.
    pub fn is_reversed(self) -> bool {
        self.0 & 1 != 0
    }
}

impl Cluster {
    /// The facing word in which all of the cluster's triangles face the light.
    pub fn full_word(&self) -> u64 {
        u64::MAX >> (CLUSTER_TRIANGLES as u32 - self.triangle_count)
    }

    /// Range of the cluster's triangles in [`EdgeMesh::corners`].
    pub fn triangles(&self) -> Range<usize> {
        range(self.first_triangle, self.triangle_count)
    }

    /// Range of the cluster's edges in [`EdgeMesh::inner_edges`].
    pub fn inner(&self) -> Range<usize> {
        range(self.first_inner, self.inner_count)
    }

    /// Range of the cluster's seams in [`EdgeMesh::seam_sides`] and [`EdgeMesh::seam_slots`].
    pub fn seams(&self) -> Range<usize> {
        range(self.first_seam, self.seam_count)
    }

    /// Range in [`EdgeMesh::seam_clusters`] of the clusters that this cluster's seams lead to.
    pub fn seam_clusters(&self) -> Range<usize> {
        range(self.first_seam_cluster, self.seam_cluster_count)
    }

    /// Range of the boundary edges of the cluster's triangles in [`EdgeMesh::boundary_vertices`].
    pub fn boundary(&self) -> Range<usize> {
        range(self.first_boundary, self.boundary_count)
    }
}

fn range(first: u32, count: u32) -> Range<usize> {
    first as usize..(first + count) as usize
}

impl EdgeMesh {
    /// Number of positions that the mesh was built from; vertices index into that many positions.
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Number of triangles that cast.
    pub fn triangle_count(&self) -> usize {
        self.corners.len()
    }

    /// Number of triangles in closed pieces. They come first.
    pub fn closed_triangle_count(&self) -> usize {
        self.clusters[..self.closed_cluster_count]
            .last()
            .map_or(0, |cluster| cluster.triangles().end)
    }

    /// Whether every piece is closed. A mesh without triangles is closed.
    pub fn is_closed(&self) -> bool {
        self.closed_cluster_count == self.clusters.len()
    }

    /// Counts of triangles that were left out of the mesh.
    pub fn report(&self) -> EdgeMeshReport {
        self.report
    }

    /// Welded vertices of every triangle, cluster after cluster. Corners are in the order of the input.
    pub fn corners(&self) -> &[[u32; 3]] {
        &self.corners
    }

    /// All clusters; those of closed pieces come first.
    pub fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// Number of clusters of closed pieces.
    pub fn closed_cluster_count(&self) -> usize {
        self.closed_cluster_count
    }

    /// Regular edges inside clusters. A regular edge has exactly two triangles, which traverse it in opposite
    /// directions.
    ///
    /// An edge names a side of a triangle instead of its vertices. This takes an eighth of the memory, and
    /// the caps read the corners anyway.
    pub fn inner_edges(&self) -> &[InnerEdge] {
        &self.inner_edges
    }

    /// Regular edges between two clusters, each as a side of its triangle in the earlier cluster.
    pub fn seam_sides(&self) -> &[LaneSide] {
        &self.seam_sides
    }

    /// For each entry of [`EdgeMesh::seam_sides`], the slot of its triangle in the later cluster.
    pub fn seam_slots(&self) -> &[u32] {
        &self.seam_slots
    }

    /// For each cluster, the later clusters that it shares an edge with, ascending.
    /// [`Cluster::seam_clusters`] is a cluster's range.
    pub fn seam_clusters(&self) -> &[u32] {
        &self.seam_clusters
    }

    /// Number of regular edges, inside and between clusters.
    pub fn regular_count(&self) -> usize {
        self.inner_edges.len() + self.seam_sides.len()
    }

    /// Edges that have a single triangle, in the direction in which it traverses them. They belong to open
    /// pieces.
    pub fn boundary_vertices(&self) -> &[[u32; 2]] {
        &self.boundary_vertices
    }

    /// For each entry of [`EdgeMesh::boundary_vertices`], the slot of its triangle, ascending.
    pub fn boundary_slots(&self) -> &[u32] {
        &self.boundary_slots
    }

    /// Edges that are neither regular nor boundary: they have three or more triangles, or two that traverse
    /// them in the same direction.
    pub fn irregular_vertices(&self) -> &[[u32; 2]] {
        &self.irregular_vertices
    }

    /// The triangles at the irregular edge with index `edge`.
    pub fn irregular_sides(&self, edge: usize) -> &[EdgeSide] {
        &self.irregular_sides[self.irregular_starts[edge] as usize..self.irregular_starts[edge + 1] as usize]
    }

    /// Number of edges of all kinds.
    pub fn edge_count(&self) -> usize {
        self.regular_count() + self.boundary_vertices.len() + self.irregular_vertices.len()
    }

    /// Bytes of this structure for each triangle. Face planes are kept elsewhere and not included.
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
