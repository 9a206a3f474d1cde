//! edge_mesh
