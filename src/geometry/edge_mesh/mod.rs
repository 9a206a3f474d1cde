//! Triangle meshes in the form that silhouettes need: vertices welded by position, every edge with *all* of
//! its triangles, and triangles grouped into clusters of one facing word each.
//!
//! **Any triangle soup casts.** Each triangle, turned to face the light, bounds an infinite volume by itself
//! (the triangle, its three edges extruded, the triangle at infinity). The number of such volumes around a
//! point is the number of triangles between the point and the light. In their sum the directed edges add with
//! sign: edges inside a uniformly facing patch cancel, and the contour remains, closed for any input. Source:
//! Crow 1977, "Shadow Algorithms for Computer Graphics", applied to single triangles instead of closed
//! solids.
//!
//! | file | holds |
//! | --- | --- |
//! | `mesh` | [`EdgeMesh`] and its parts |
//! | `build` | [`EdgeMesh::build`] |
//! | `half_edges` | edges of triangles, sorted |
//! | `pieces` | connected pieces, and which of them are closed |
//! | `repeats` | triangles that are modelled several times in one place |
//! | `weld` | welding of vertices |
//! | `winding` | whether the outside of a mesh is seen from everywhere around it |
//! | `order` | the order of triangles, which decides who shares a cluster |
//! | `error` | [`EdgeMeshError`] |

mod build;
mod error;
mod half_edges;
mod mesh;
mod order;
mod pieces;
mod repeats;
mod weld;
mod winding;

pub use build::EdgeMeshInput;
pub use error::EdgeMeshError;
pub use mesh::{Cluster, EdgeMesh, EdgeMeshReport, EdgeSide, InnerEdge, LaneSide};
pub use winding::is_outside_out;
