//! Shadow maps of spot lights and, in cascades, of directional lights.
//!
//! | file | holds |
//! | --- | --- |
//! | `component` | [`ShadowMap`], which a user sets on a light |
//! | `technique` | how the component joins the frame |
//!
//! Everything else is shared with the maps of point lights, in [`maps`](super::maps).

pub(crate) mod component;
pub(crate) mod technique;

pub use super::maps::Cascades;
pub use component::ShadowMap;
