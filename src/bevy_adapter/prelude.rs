//! The names that a Bevy game needs.

pub use super::{AntumbraCamera, AntumbraDiagnosticsPlugin, AntumbraSettings};
pub use crate::plugin::AntumbraPlugin;
pub use crate::scene::{
    BarnMap, BlurredGround, Cookie, CookieImage, LightDistance, LightPath, LightProfile, LightSelection,
    LightShape, LightWeights, ShadowOrigin, ShadowSoftness, ShadowTint, SurfaceWeights,
};
pub use crate::techniques::{
    AddTechnique, OcclusionInterval, OcclusionTexture, OmniMap, PenumbraWedge, PerspectiveMap, ShadowMap,
    Smoothie, StencilVolume,
};
