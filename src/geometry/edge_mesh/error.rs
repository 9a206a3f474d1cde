//! Why a mesh cannot become an [`EdgeMesh`](super::EdgeMesh).

/// Why a mesh cannot become an [`EdgeMesh`](super::EdgeMesh). Bad shapes are no error: they cast all the same.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EdgeMeshError {
    /// A corner names a vertex that the mesh does not have.
    #[error("triangle {triangle} names vertex {index}, the mesh has {vertex_count}")]
    IndexOutOfRange {
        /// Triangle in the order of the input.
        triangle: usize,
        /// What its corner says.
        index: u32,
        /// Positions given.
        vertex_count: usize,
    },
    /// The last triangle lacks corners.
    #[error("{index_count} indices do not make whole triangles: triangle {triangle} is cut short")]
    IncompleteTriangle {
        /// Indices given.
        index_count: usize,
        /// The triangle that lacks corners.
        triangle: usize,
    },
    /// Pose keys go with vertices one to one.
    #[error("{key_count} pose keys for {vertex_count} vertices")]
    PoseKeyCount {
        /// Keys given.
        key_count: usize,
        /// Positions given.
        vertex_count: usize,
    },
    /// The width of a welding cell is a positive finite length.
    #[error("weld epsilon {0} is not a positive finite length")]
    WeldEpsilon(f32),
    /// Vertices and indices are counted in 32 bits.
    #[error("{vertex_count} vertices and {index_count} indices do not fit into 32 bits")]
    TooLarge {
        /// Positions given.
        vertex_count: usize,
        /// Indices given.
        index_count: usize,
    },
}
