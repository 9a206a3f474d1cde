//! From the silhouette of one caster to wedges. These are pure functions on flat arrays.

pub(crate) mod clip;
pub(crate) mod cut;
mod cut_outlines;
pub(crate) mod cut_patches;
mod cut_pieces;
pub(crate) mod ends;
mod layer_split;
pub(crate) mod patches;
pub mod records;
pub(crate) mod shell;
pub(crate) mod sight;
pub mod silhouette_layers;
#[cfg(feature = "render")]
pub(crate) mod topology;
