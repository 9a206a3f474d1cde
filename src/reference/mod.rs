//! The CPU judge: ray-cast visibility, slow and exact. Every technique is measured against it.
//!
//! ```text
//! RayScene ──► primary_hits(camera) ──► hard_visibility / soft_visibility(light) ──► compare_hard / compare_soft
//! triangles     surface per pixel        VisibilityImage (NaN: does not count)        HardError / SoftError
//! ```
//!
//! | file | subject |
//! | --- | --- |
//! | `ray` | the ray, and its watertight intersection with a triangle in `f64` |
//! | `contact` | the triangles that touch a surface point and so cannot shadow it |
//! | `bvh` | the triangles that a ray may hit |
//! | `ray_scene`, `gather` | the triangles of a world; the two shadow queries |
//! | `primary` | the surface that each pixel shows |
//! | `light_source` | where a light is sampled, and which surface points count for it |
//! | `visibility` | visibility of every pixel |
//! | `metrics`, `difference_image` | the error of an answer, in numbers and as a picture |
//!
//! **What counts as truth.** A surface point sees a light sample if no blocking triangle crosses the segment
//! between them. Blocking is two-sided. The receiving triangle does not block, nor does any triangle that the
//! point touches (`contact` defines touching), nor a triangle that is nearer to the sample than the light's
//! clearance ([`RayScene::clearance`]). A sample below the horizon of the surface is not seen. Alpha is ignored:
//! masked and blended materials are seen and block as a whole.
//!
//! Nothing here panics. The work runs on the threads of the current `rayon` pool, and no result depends on
//! their number.

mod bvh;
mod contact;
mod difference_image;
mod error;
mod gather;
mod light_source;
mod metrics;
mod primary;
mod ray;
mod ray_scene;
mod sampling;
mod suspects;
mod visibility;

pub use difference_image::{DifferenceImage, difference_image};
pub use error::ReferenceError;
pub use light_source::{LightShape, LightSource};
pub use metrics::{HardError, SoftError, compare_hard, compare_soft, edge_band};
pub use primary::{HitImage, PrimaryCulling, SurfaceHit, camera_rays, primary_hits, primary_hits_culled};
pub use ray::{Ray, RayHit};
pub use ray_scene::{MAX_COORDINATE, RayScene, SceneTriangle};
pub use visibility::{VisibilityImage, hard_visibility, soft_visibility, soft_visibility_at};
