//! What a game names.

pub use super::{AntumbraCamera, AntumbraSettings};
pub use crate::plugin::AntumbraPlugin;
pub use crate::scene::LightSelection;
pub use crate::techniques::{AddTechnique, OmniMap, PenumbraWedge, ShadowMap, StencilVolume};
