//! The names that a Bevy game needs.

pub use super::{AntumbraCamera, AntumbraSettings};
pub use crate::plugin::AntumbraPlugin;
pub use crate::scene::{
    Cookie, CookieImage, LightDistance, LightPath, LightProfile, LightSelection, LightShape, LightWeights,
    ShadowOrigin, ShadowSoftness, ShadowTint,
};
pub use crate::techniques::{
    AddTechnique, OcclusionInterval, OmniMap, PenumbraWedge, ShadowMap, StencilVolume,
};
