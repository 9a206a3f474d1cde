//! Occlusion: which objects are hidden from the camera and from each light. It is conservative: an object is
//! left out only if no pixel of the real picture would show any part of it.
//!
//! | file | holds |
//! | --- | --- |
//! | `settings` | [`OcclusionSettings`]: what is switched on and what it may cost |
//! | `occluders` | [`Occluders`]: the objects that may hide others |
//! | `occluder_mesh` | `OccluderMesh`: the triangles and edges of an occluder |
//! | `cells` | [`Cells`]: rooms, openings, and the cells of each object |
//! | `flood` | what is visible from a place in a cell, through one portal after another |
//! | `sight` | a convex cone of directions, and the part of it that passes an opening |
//! | `projection` | [`Projection`]: from the world to the texels of a picture |
//! | `beam` | the part of space behind a rectangle of a picture |
//! | `clip` | clipping of triangles to what a picture can hold |
//! | `texel_layers` | what a texel may claim, and why the claim holds |
//! | `raster` | [`Rasterizer`]: from triangles to layers |
//! | `depth_buffer` | `DepthBuffer`: how near something certainly stands; the test of boxes |
//! | `light_views` | the pictures that together show everything that a light sees |
//! | `viewpoint` | [`Viewpoint`]: the depth buffers of the camera or of a light |
//!
//! Source: Zhang, Manocha, Hudson & Hoff 1997, "Visibility Culling using Hierarchical Occlusion Maps", for
//! testing bounds against a hierarchy over a rasterised picture of chosen occluders; O'Rorke 2004, GPU Gems
//! ch. 15, §15.4, for doing so from every light. The rule for what a texel may claim is ours.

mod beam;
pub(crate) mod cells;
mod clip;
pub(crate) mod depth_buffer;
mod flood;
pub(crate) mod light_views;
pub(crate) mod occluder_mesh;
pub(crate) mod occluders;
pub(crate) mod projection;
pub(crate) mod raster;
pub(crate) mod settings;
mod sight;
mod texel_layers;
pub(crate) mod viewpoint;

pub use cells::{CellIssue, Cells, collect_cells};
pub(super) use flood::{Sightings, Standpoint};
pub use occluders::{Occluders, collect_occluders};
pub use projection::Projection;
pub use raster::Rasterizer;
pub use settings::{AutoOccluders, OcclusionSettings};
pub use viewpoint::Viewpoint;
