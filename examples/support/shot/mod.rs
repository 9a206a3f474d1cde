//! The shot file: a scene, a camera, lights, and the size of the picture, as JSON.

mod camera;
#[cfg(feature = "serde")]
mod file;
#[cfg(feature = "serde")]
mod light;

pub use camera::ShotCamera;
#[cfg(feature = "serde")]
pub use file::Shot;
#[cfg(feature = "serde")]
pub use light::ShotLight;
