//! Omnidirectional shadow maps: six faces of a cube around the light, of squared distance or of depth.
//!
//! | file | holds |
//! | --- | --- |
//! | `component` | [`OmniMap`], which a user sets on a light |
//! | `technique` | how the component joins the frame |
//!
//! Everything else is shared with the maps of other lights, in [`maps`](super::maps).
//! Source: Gerasimov 2004, "Omnidirectional Shadow Mapping", GPU Gems ch. 12.

pub(crate) mod component;
pub(crate) mod technique;

pub use component::OmniMap;
