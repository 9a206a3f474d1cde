//! Stencil shadow volumes: hard shadows, exact to the pixel, without bias.
//!
//! | file | holds |
//! | --- | --- |
//! | `component` | [`StencilVolume`], which a user sets on a light |
//! | `volumes` | the frame's volumes, and how they are counted |
//! | `volume_parts` | which parts of a volume are drawn |
//! | `technique` | how the component joins the frame |
//! | `gpu/recorder` | the recorder (feature `render`) |
//! | `gpu/pipelines` | pipelines of volumes (feature `render`) |
//! | `gpu/quads` | indices of side quads (feature `render`) |
//!
//! Extrusion, the test whether the viewport may be in a caster's shadow, and contours on the GPU are in
//! `shared`.
//!
//! Source: McGuire 2004, "Efficient Shadow Volume Rendering", GPU Gems ch. 9.

pub(crate) mod caster_volume;
mod component;
#[cfg(feature = "render")]
pub(crate) mod gpu;
pub(crate) mod technique;
pub(crate) mod volume_parts;
pub(crate) mod volumes;

pub use caster_volume::CasterVolume;
pub use component::{Counting, Extent, MOST_STACKED, StencilVolume};
pub use volumes::{LightVolumes, StencilVolumes};
