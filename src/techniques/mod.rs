//! Shadow techniques, one folder each: its component, its CPU geometry and systems, its recorder.
//!
//! A technique is a component on the light; lights choose separately, and any mix renders in one frame. What a
//! technique leaves is visibility (1 where a surface point sees the whole light, 0 where it sees none), and the light
//! pass multiplies by it and knows nothing else about techniques.

pub mod stencil_volume;

pub use stencil_volume::StencilVolume;
