//! The shot file: a scene, a camera, lights, and the size of the picture, as JSON.

mod camera;
mod file;
mod light;
mod model;
mod textures;

pub use camera::ShotCamera;
pub use file::Shot;
pub use light::{ShotEmission, ShotLight};
pub use model::ShotModel;
