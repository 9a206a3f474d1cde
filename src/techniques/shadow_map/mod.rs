//! Shadow maps of spot lights and, in cascades, of directional lights.
//!
//! | file | holds |
//! | --- | --- |
//! | `component` | [`ShadowMap`] and [`Cascades`], which a user sets on a light |
//! | `cascades` | the boxes that a directional light's maps show |
//!
//! Everything else is shared with the maps of point lights, in [`maps`](super::maps).

pub(crate) mod cascades;
pub(crate) mod component;

pub use component::{Cascades, ShadowMap};
