//! What the examples and tests share: shot files, a stage to render them on, and pictures on disk.

#![allow(dead_code, reason = "each example and test uses a part")]

pub mod model;
pub mod picture;
#[cfg(feature = "serde")]
pub mod shadow;
pub mod shot;
pub mod solid;
pub mod spread;
pub mod stage;
pub mod stats;
#[cfg(feature = "reference")]
pub mod table;
#[cfg(feature = "reference")]
pub mod walk;
