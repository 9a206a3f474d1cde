//! Pure mathematics on `glam`: no ECS, no GPU.

pub mod aabb;
pub mod box_shadow;
pub mod cone;
pub mod convex_polygon;
pub mod edge_mesh;
pub mod frustum;
pub mod light_hull;
pub mod plane_set;
pub mod sphere;
pub mod triangle;

pub use aabb::Aabb;
pub use box_shadow::BoxShadow;
pub use cone::Cone;
pub use frustum::{Frustum, FrustumShape};
pub use light_hull::{Emitter, LightHull, SolidEdge};
pub use plane_set::{Plane, PlaneSet, excludes_points};
pub use sphere::Sphere;
pub use triangle::distance_to_triangle;
