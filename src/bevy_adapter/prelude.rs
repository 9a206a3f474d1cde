//! What a game names.

pub use super::{AddShadowTechnique, AntumbraCamera, AntumbraSettings};
pub use crate::plugin::AntumbraPlugin;
pub use crate::scene::LightSelection;
pub use crate::techniques::{OmniMap, PenumbraWedge, ShadowMap, StencilVolume};
