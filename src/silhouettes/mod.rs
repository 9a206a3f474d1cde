//! Silhouettes: which triangles of a caster face a light, and the contour between those that do and those that
//! do not. Pure functions on flat arrays; buffers are the caller's and are reused, so a steady frame allocates
//! nothing.
//!
//! ```text
//! EdgeMesh + positions ──► FacingPlanes ──► FacingBits ──► Contour ──► Loops
//!    once a mesh         once a pose    └──── once a (light, caster) ─────┘
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `planes` | a plane a triangle and bounds a cluster |
//! | `facing` | a bit a triangle, 64 at a time |
//! | `turning` | a bit a triangle: whether its plane cuts the light |
//! | `grazed` | a bit a triangle: whether the light lies in or on it, so that it blocks nothing |
//! | `stacks` | how many casters lie one behind the other |
//! | `contour` | what a volume is made of; cap triangles |
//! | `edges` | signed edges |
//! | `loops` | the contour as closed loops |

pub(crate) mod cache;
pub(crate) mod casters;
mod contour;
mod edges;
mod facing;
pub(crate) mod grazed;
mod loops;
mod planes;
pub(crate) mod stacks;
mod turning;

pub use cache::{LightSilhouettes, NeedsSilhouettes, Silhouette, Silhouettes};
pub use casters::{CasterEdges, CasterMesh, CasterMeshes, PosedPlanes};
pub use contour::{CapMode, Contour, extract_caps, extract_contour};
pub use edges::extract_edges;
pub use facing::{FacingBits, classify, classify_scalar};
pub use grazed::{GrazingLight, LightClearance, find_grazed, take_out_of_contour};
pub use loops::{LoopError, Loops, link_loops};
pub use planes::{FacingPlanes, compute_planes, compute_posed_planes};
pub use turning::{LightExtent, find_turning};
