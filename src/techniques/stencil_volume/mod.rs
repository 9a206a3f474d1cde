//! Stencil shadow volumes: hard shadows, exact to the pixel, without bias.
//!
//! | file | holds |
//! | --- | --- |
//! | [`component`] | what a user sets on a light |
//! | [`extrude`] | far corners and the bounds of a volume; the twin of the vertex shader |
//! | [`inside_test`] | whether the viewport may lie in a caster's shadow: depth-fail or depth-pass |
//! | [`parts`] | which parts of a volume are drawn |
//! | [`volumes`] | the frame's volumes |
//! | `contour_pool` | silhouettes on the GPU (feature `render`) |
//! | `volume_pipelines` | what tells two draws of volumes apart (feature `render`) |
//! | `quads` | indices of side quads (feature `render`) |
//! | `node` | the recorder (feature `render`) |
//!
//! Source: McGuire 2004, "Efficient Shadow Volume Rendering", GPU Gems ch. 9.

mod component;
#[cfg(feature = "render")]
pub(crate) mod gpu;
pub(crate) mod volume_parts;
pub(crate) mod volumes;

pub use component::{Counting, Extent, MOST_STACKED, StencilVolume};
pub use volumes::{CasterVolume, LightVolumes, StencilVolumes};
