//! Triangle meshes as silhouettes need them: welded by position, every edge with *all* of its triangles,
//! triangles grouped into clusters of one facing word each.
//!
//! **Any triangle soup casts.** Each triangle, turned to face the light, bounds an infinite volume by itself
//! (the triangle, its three edges extruded, the triangle at infinity). The number of such volumes around a
//! point is the number of triangles between it and the light. In their sum the directed edges add with sign:
//! an edge inside a uniformly facing patch cancels, and what is left is the contour, closed for any input.
//! Source: Crow 1977, "Shadow Algorithms for Computer Graphics", taken from closed solids to single triangles.
//!
//! | file | holds |
//! | --- | --- |
//! | `mesh` | [`EdgeMesh`] and its parts |
//! | `build` | [`EdgeMesh::build`] |
//! | `pieces` | which triangles hang together, and which pieces are closed |
//! | `weld` | which vertices are one |
//! | `winding` | whether a mesh is outside out everywhere |
//! | `order` | which triangles share a cluster |
//! | `error` | [`EdgeMeshError`] |

mod build;
mod error;
mod mesh;
mod order;
mod pieces;
mod weld;
mod winding;

pub use build::EdgeMeshInput;
pub use error::EdgeMeshError;
pub use mesh::{Cluster, EdgeMesh, EdgeMeshReport, EdgeSide, InnerEdge, LaneSide};
pub use winding::is_outside_out;
