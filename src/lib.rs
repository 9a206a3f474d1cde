//! Data-oriented shadows and lighting for `bevy_ecs` + `wgpu`.

pub mod conventions;
pub mod geometry;
pub mod plugin;
#[cfg(feature = "reference")]
pub mod reference;
#[cfg(feature = "render")]
pub mod render;
pub mod scene;
pub mod sets;
pub mod silhouettes;
pub mod techniques;
