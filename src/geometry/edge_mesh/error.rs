//! Why a mesh cannot become an [`EdgeMesh`](super::EdgeMesh).

/// Why a mesh cannot become an [`EdgeMesh`](super::EdgeMesh). A bad shape is no error: it still casts.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EdgeMeshError {
    /// A corner names a vertex that the mesh does not have.
    #[error("triangle {triangle} names vertex {index}, the mesh has {vertex_count}")]
    IndexOutOfRange {
        /// Index of the triangle in the input.
        triangle: usize,
        /// Vertex index that the corner names.
        index: u32,
        /// Number of positions in the input.
        vertex_count: usize,
    },
    /// The last triangle lacks corners.
    #[error("{index_count} indices do not make whole triangles: triangle {triangle} is cut short")]
    IncompleteTriangle {
        /// Number of indices in the input.
        index_count: usize,
        /// The triangle that lacks corners.
        triangle: usize,
    },
    /// The number of pose keys differs from the number of vertices.
    #[error("{key_count} pose keys for {vertex_count} vertices")]
    PoseKeyCount {
        /// Number of pose keys in the input.
        key_count: usize,
        /// Number of positions in the input.
        vertex_count: usize,
    },
    /// The width of a welding cell is not a positive finite length.
    #[error("weld epsilon {0} is not a positive finite length")]
    WeldEpsilon(f32),
    /// The mesh has more vertices or indices than 32 bits can count.
    #[error("{vertex_count} vertices and {index_count} indices do not fit into 32 bits")]
    TooLarge {
        /// Number of positions in the input.
        vertex_count: usize,
        /// Number of indices in the input.
        index_count: usize,
    },
}
