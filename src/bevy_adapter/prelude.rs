//! The names that a Bevy game needs.

pub use super::{AntumbraCamera, AntumbraSettings};
pub use crate::plugin::AntumbraPlugin;
pub use crate::scene::{
    BarnMap, Cookie, CookieImage, LightDistance, LightProfile, LightSelection, LightShape, LightWeights,
    ShadowOrigin, ShadowSoftness, ShadowTint, SurfaceWeights,
};
pub use crate::techniques::{AddTechnique, OmniMap, PenumbraWedge, ShadowMap, StencilVolume};
