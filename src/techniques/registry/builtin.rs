//! The list of the crate's techniques.

use super::add_technique::AddTechnique;
use crate::techniques::{
    OcclusionInterval, OcclusionTexture, OmniMap, PenumbraWedge, PerspectiveMap, ShadowMap, Smoothie,
    StencilVolume,
};

/// Adds the crate's own techniques. This is their only list. If a light has several techniques, the one that
/// was added first shadows it.
pub fn add_builtin(to: &mut impl AddTechnique) {
    to.add_technique::<StencilVolume>();
    to.add_technique::<PenumbraWedge>();
    to.add_technique::<ShadowMap>();
    to.add_technique::<OmniMap>();
    to.add_technique::<Smoothie>();
    to.add_technique::<PerspectiveMap>();
    to.add_technique::<OcclusionTexture>();
    to.add_technique::<OcclusionInterval>();
}
