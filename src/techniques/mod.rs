//! Shadow techniques, one folder each: its component, its CPU geometry and systems, its recorder.
//!
//! A technique is a component on a light. Each light chooses its own, and any mix renders in one frame. A
//! technique leaves visibility: 1 where a surface point sees the whole light, 0 where it sees none of it. The
//! light pass multiplies by visibility and knows nothing else about techniques.
//!
//! [`Technique`] is the trait, and [`add_builtin`] is the one list: a new technique is a folder here and a line
//! there. A technique of somebody else is a type and a call ([`AddTechnique`]).

pub mod maps;
pub mod omni_map;
pub mod penumbra_wedge;
pub(crate) mod registry;
pub mod shadow_map;
pub(crate) mod shared;
pub mod stencil_volume;

pub use crate::sets::{LightTechnique, NeededSilhouettes, Needs};
/// What [`Technique::parse`] reads from.
#[cfg(feature = "serde")]
pub use erased_serde;
pub use omni_map::OmniMap;
pub use penumbra_wedge::{PenumbraWedge, PenumbraWedges};
pub use registry::{
    AddTechnique, Refusal, Row, Settings, Statistic, Statistics, Technique, TechniqueSystems, Techniques,
    add_builtin, add_row, choose_techniques,
};
pub use shadow_map::ShadowMap;
pub use stencil_volume::StencilVolume;
