//! The names that a Bevy game needs.

pub use super::{AntumbraCamera, AntumbraDiagnosticsPlugin, AntumbraSettings};
#[cfg(feature = "bevy-gizmos")]
pub use super::{AntumbraGizmos, AntumbraGizmosPlugin};
pub use crate::plugin::AntumbraPlugin;
pub use crate::scene::{
    BarnMap, BlurredGround, Cell, Cookie, CookieImage, InCells, LightDistance, LightPath, LightProfile,
    LightSelection, LightShape, LightWeights, Occluder, Portal, ShadowOrigin, ShadowSoftness, ShadowTint,
    SurfaceWeights,
};
pub use crate::techniques::{
    AddTechnique, OcclusionInterval, OcclusionTexture, OmniMap, PenumbraWedge, PerspectiveMap, ShadowMap,
    Smoothie, StencilVolume,
};
