//! Shadow techniques. Each has a folder with its component, its CPU geometry and systems, and its recorder.
//!
//! A technique is a component on a light. Each light chooses its own technique, and any mix renders in one
//! frame. A technique that knows only a part of the scene leaves the rest to a second one on the same light
//! ([`Technique::LEAVES_OTHERS`]). A technique computes visibility: 1 where a surface point sees the whole light,
//! 0 where it sees none of it. The light pass multiplies by visibility and knows nothing else about techniques.
//!
//! [`Technique`] is the trait, and [`add_builtin`] is the list of the crate's techniques. A new technique of
//! the crate is a folder here and a line in that list. A technique of another crate is a type that implements
//! the trait, added by one call ([`AddTechnique`]).

pub mod maps;
pub mod occlusion_interval;
pub mod occlusion_texture;
pub mod omni_map;
pub mod penumbra_wedge;
pub mod perspective_map;
pub(crate) mod registry;
pub mod shadow_map;
pub(crate) mod shared;
pub mod smoothie;
pub mod stencil_volume;

pub use crate::sets::{LeftObjects, LightTechnique, NeededSilhouettes, Needs};
/// The crate whose deserializers [`Technique::parse`] reads from.
#[cfg(feature = "serde")]
pub use erased_serde;
pub use maps::{Cascades, MapBias, MapFilter, MapFormat, MapResolution, MapSurface};
pub use occlusion_interval::{IntervalFolder, IntervalLibrary, IntervalMaps, OcclusionInterval};
pub use occlusion_texture::{OcclusionTexture, OcclusionTextures, SliceCombination, SliceFilter};
pub use omni_map::OmniMap;
pub use penumbra_wedge::{
    CoverageMaths, Overlap, PenumbraWedge, PenumbraWedges, VisibilityBuffer, WedgeBounds, WedgeCulling,
    WedgeSilhouette,
};
pub use perspective_map::{
    MapFocus, PerspectiveFaces, PerspectiveMap, PerspectiveMaps, PerspectiveProjection,
};
pub use registry::{
    AddTechnique, FileError, LeavingSystems, Refusal, Row, Settings, Statistic, Statistics, SurfacePatch,
    Technique, TechniqueSystems, Techniques, TexelLookup, add_builtin, add_row, choose_techniques,
};
#[cfg(feature = "schema")]
pub use schemars;
pub use shadow_map::ShadowMap;
pub use shared::texture_memory::{
    Shortage, Storage, TextureGrant, TextureMemory, TextureMemorySystems, TextureShortage, TextureWant,
};
pub use smoothie::{Smoothie, SmoothieWidth};
pub use stencil_volume::{Counting, Extent, StencilVolume};
