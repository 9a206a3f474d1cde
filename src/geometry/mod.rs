//! Mathematics on `glam` and `wide`, without ECS or GPU.

pub(crate) mod aabb;
pub(crate) mod box_shadow;
pub(crate) mod cone;
pub(crate) mod convex_polygon;
pub(crate) mod convex_shell;
pub(crate) mod convex_solid;
pub mod edge_mesh;
pub(crate) mod enclosure;
pub(crate) mod frustum;
pub(crate) mod light_hull;
pub(crate) mod plane_set;
pub(crate) mod pyramid;
pub(crate) mod sphere;
pub(crate) mod triangle;
pub(crate) mod triangle_grid;

pub use aabb::Aabb;
pub use box_shadow::BoxReceivers;
pub use cone::Cone;
pub use convex_solid::SolidEdge;
pub use enclosure::winding_number;
pub use frustum::{Frustum, FrustumShape};
pub use light_hull::{Emitter, LightHull};
pub use plane_set::{Plane, PlaneSet, excludes_points};
pub use pyramid::Pyramid;
pub use sphere::Sphere;
pub use triangle::distance_to_triangle;
