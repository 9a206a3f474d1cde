//! The shot file: a scene, a camera, lights, and the size of the picture, as JSON.
//!
//! [`antumbra::guide::shot_file`] lists all keys. An unknown key is an error, and so is a number that cannot be used.
//!
//! # The light model
//!
//! Each light may have the keys of [`ShotModel`] beside its kind, place and technique. `affects`, `casts_for` and `shows_on`
//! are lists of names.
//!
//! A name is that of nodes of the scene, which stand for themselves and all nodes below them, or that of a layer in
//! the `extras.antumbra.layers` of a node.
//!
//! ```json
//! {"kind": "spot", "position": [0, 3, 0], "direction": [0, -1, 0], "inner_deg": 40, "outer_deg": 50,
//!  "shape": {"width": 0.4, "height": 0.3, "width_edge": 0.1, "height_edge": 0.1, "round": 0.5},
//!  "distance": {"near": 1, "far": 6, "near_edge": 0.5, "far_edge": 2},
//!  "weights": {"ambient": 0, "diffuse": 1, "specular": 1},
//!  "shadow_color": [0, 0, 0.2], "shadow_darkness": 0.8, "shadow_origin": [1, 3, 0], "shadow_softness": 0.2,
//!  "affects": ["hero"], "casts_for": ["set"], "shows_on": ["floor"]}
//! ```
//!
//! # The path
//!
//! A light with the technique `occlusion_interval` has a key `path`, which is one of these:
//!
//! | path | meaning |
//! | --- | --- |
//! | `{"axis": [0, 0, 1], "degrees": 150}` | a directional light turns about the axis; `direction` is that of time 0 |
//! | `{"latitude_deg": 50, "day": 172}` | a directional light is the sun from midnight to midnight; `"hours": [6, 18]` takes a part of the day. +X is east, −Z is north |
//! | `{"positions": [[0, 2, 0], [4, 2, 0]]}` | a point or spot light moves along a polyline |

mod camera;
mod emission;
mod file;
mod keys;
mod light;
mod model;
mod path;
mod schema;
mod textures;

pub use camera::ShotCamera;
pub use emission::ShotEmission;
pub use file::{Shot, ShotAnimation, ShotGround};
pub use light::{LightParts, ShotLight};
pub use model::ShotModel;
pub use path::ShotPath;
pub use schema::{shot_schema, tidy};
