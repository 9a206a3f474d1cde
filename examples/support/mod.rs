//! Shared code of the examples and tests: shot files, a stage to render them on, and pictures on disk.

#![cfg(all(feature = "render", feature = "gltf"))]
#![allow(missing_docs, reason = "names of a shot file are explained by the guide")]

pub mod frames;
#[cfg(feature = "reference")]
pub mod given;
pub mod model;
pub mod picture;
pub mod shadow;
pub mod shared_gpu;
pub mod shot;
pub mod soak;
pub mod solid;
pub mod spread;
pub mod stage;
pub mod stats;
#[cfg(feature = "reference")]
pub mod table;
#[cfg(feature = "reference")]
pub mod texels;
#[cfg(feature = "reference")]
pub mod walk;
