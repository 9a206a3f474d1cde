//! The shot file: a scene, a camera, lights, and the size of the picture, as JSON.

mod camera;
mod file;
mod light;

pub use camera::ShotCamera;
pub use file::Shot;
pub use light::ShotLight;
