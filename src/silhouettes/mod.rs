//! Silhouettes: which triangles of a caster face a light, and the contour between those that do and those
//! that do not.
//!
//! These are pure functions on flat arrays. The caller owns the buffers and reuses them, so a steady frame
//! allocates nothing.
//!
//! ```text
//! EdgeMesh + positions ──► FacingPlanes ──► FacingBits ──► Contour ──► Loops
//!    once a mesh         once a pose    └──── once a (light, caster) ─────┘
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `planes` | one plane per triangle, bounds per cluster |
//! | `facing` | one bit per triangle: whether it faces the light; 64 at a time |
//! | `turning` | one bit per triangle: whether its plane cuts the light |
//! | `grazed` | one bit per triangle: whether the light lies in or on it, so that it blocks nothing |
//! | `flush` | edges of a surface on which the light lies |
//! | `stacks` | how many casters lie one behind the other |
//! | `contour` | what a volume is made of |
//! | `caps` | cap triangles |
//! | `edges` | signed edges |
//! | `loops` | the contour as closed loops |
//! | `buried` | shadow origins that lie inside of casters |
//! | `casters` | edge meshes of casters, planes of posed casters |
//! | `coincident` | casters with the same triangles in the same place |
//! | `light_silhouettes` | silhouettes by light and caster, in slots |
//! | `object_slots` | which objects have a slot |
//! | `cache` | the extraction of those that are not known yet or are stale |

pub(crate) mod buried;
pub(crate) mod cache;
mod caps;
pub(crate) mod caster_shape;
pub(crate) mod casters;
pub(crate) mod coincident;
mod contour;
mod edges;
mod facing;
mod flush;
pub(crate) mod grazed;
pub(crate) mod light_silhouettes;
mod loops;
mod object_slots;
mod planes;
pub(crate) mod report;
pub(crate) mod stacks;
mod turning;

pub use buried::BuriedOrigins;
pub use caps::{extract_caps, extract_contour};
pub use caster_shape::{CasterShape, CasterShapeItem};
pub use casters::{CasterEdges, CasterMesh, CasterMeshes, PosedPlanes, RefusedCaster};
pub use coincident::CoincidentCasters;
pub use contour::{CapMode, Contour};
pub use edges::extract_edges;
pub use facing::{FacingBits, classify, classify_scalar};
pub use flush::find_flush_edges;
pub use grazed::{GrazingLight, find_grazed, take_out_of_contour};
pub use light_silhouettes::{KEPT_FRAMES, LightSilhouettes, Silhouette, Silhouettes};
pub use loops::{LoopError, Loops, link_loops};
pub use planes::{FacingPlanes, compute_planes, compute_posed_planes};
pub use turning::{LightExtent, find_turning};

pub use crate::sets::LightClearance;
