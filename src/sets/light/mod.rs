//! Lights: the sets L, I and S of each light, its scissor rectangle and its depth bounds.

pub(crate) mod candidate;
pub(crate) mod clearance;
pub(crate) mod companion;
pub(crate) mod depth_bounds;
pub(crate) mod frame_light;
pub(crate) mod frame_lights;
pub(crate) mod illumination;
pub(crate) mod light_occlusion;
pub(crate) mod light_volume;
pub(crate) mod lit_receivers;
pub(crate) mod lit_region;
pub(crate) mod placing;
pub(crate) mod reach;
pub(crate) mod scissor;
pub(crate) mod shadow;
pub(crate) mod shadow_cone;
pub(crate) mod technique;
