//! The one list.

use super::add_technique::AddTechnique;
use crate::techniques::{OmniMap, PenumbraWedge, ShadowMap, StencilVolume};

/// The one list: adds the crate's own techniques. Where a light has several, the first that stands here shadows it.
pub fn add_builtin(to: &mut impl AddTechnique) {
    to.add_technique::<StencilVolume>();
    to.add_technique::<PenumbraWedge>();
    to.add_technique::<ShadowMap>();
    to.add_technique::<OmniMap>();
}
