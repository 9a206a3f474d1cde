//! Stencil shadow volumes: hard shadows, exact to the pixel, without bias.
//!
//! | file | holds |
//! | --- | --- |
//! | `component` | [`StencilVolume`], which a user sets on a light |
//! | `caster_volume` | the parameters of one caster's volume |
//! | `volumes` | the frame's volumes, and how they are counted |
//! | `volume_parts` | which parts of a volume are drawn |
//! | `kept` | inputs of volumes, by which lights at rest keep theirs |
//! | `technique` | how the component joins the frame |
//! | `gpu/recorder` | the recorder (feature `render`) |
//! | `gpu/long_lived` | what the recorders of all views share (feature `render`) |
//! | `gpu/pipelines` | pipelines of volumes (feature `render`) |
//! | `gpu/rounds` | ends of rounds of counting, of which each fits the stencil (feature `render`) |
//! | `gpu/quads` | indices of side quads (feature `render`) |
//!
//! Extrusion, the test whether the viewport may be in a caster's shadow, and contours on the GPU are in
//! `shared`.
//!
//! # Error and cost
//!
//! Pixels in the one-pixel band along the edges of shadows are left to rounding. Of the others, at most 0.03 % are wrong on
//! any of 40 models, and none on most, with 15 views and lights each when it was measured
//! (`cargo test --all-features --test gpu reference_match -- --nocapture` prints this). Where the edge of a volume passes
//! within the GPU's rounding of a pixel's centre, that pixel may show the other side of the edge.
//!
//! A frame with 401 objects and 8 point lights takes 1.7 times as long as the same frame without shadows, and one with 511k
//! triangles and 6 lights 1.8 times; volumes without any of the optimisations take 2.3 times in both (160×90 on a software
//! driver; `benches/frame` prints this). The cost grows with the silhouette edges of set S and with the pixels that volumes
//! cover. At rest the CPU keeps the volumes, their records and their draws; a view that moves recomputes them all.
//!
//! Source: McGuire 2004, "Efficient Shadow Volume Rendering", GPU Gems ch. 9.

pub(crate) mod caster_volume;
mod component;
#[cfg(feature = "render")]
pub(crate) mod gpu;
mod kept;
pub(crate) mod technique;
pub(crate) mod volume_parts;
pub(crate) mod volumes;

pub use caster_volume::CasterVolume;
pub use component::{Counting, Extent, MOST_STACKED, StencilVolume};
pub use volumes::{LightVolumes, StencilVolumes};
