//! Data-oriented shadows and lighting for game engines on `bevy_ecs` and `wgpu`.
//!
//! Each light chooses its own shadow technique; all techniques share one set of visibility sets, one silhouette
//! extractor, one visibility contract and one light pass.
//!
//! # The frame, as data flow
//!
//! ```text
//! scene components ──► bounds ──► sets F V L I S ──► hull, scissor, depth bounds ──► silhouettes ──► technique geometry
//!   (ECS entities)      SoA          bitsets               per light                   per light×caster     per light
//!                                                                                                             │
//!        ambient + depth (V) ◄────────────────────────────── GPU prepare ◄────────────────────────────────────┘
//!             │
//!             └─► for each light of the frame: mark visibility (S) ─► add its light (I), blend ONE ONE ─► tonemap
//! ```
//!
//! The sets of [`AntumbraSystems`](schedule::AntumbraSystems) are the arrows of the upper row; `render/frame/record.rs` is the
//! lower row, a call a pass.
//!
//! # The map
//!
//! Arrows point one way: a later folder may use an earlier one, never back (`tests/core/layers.rs` holds it).
//!
//! | folder | holds |
//! | --- | --- |
//! | [`conventions`] | handedness, depth, units, and the constants that WGSL has too |
//! | [`geometry`] | mathematics on `glam`: bounds, planes, frustum, light hull, edge meshes; no ECS |
//! | [`reports`] | what is refused, skipped or short, with the entity and what to do about it |
//! | [`scene`] | components that a user spawns; glTF import, poses, animation |
//! | [`sets`] | who is seen, lit and casts: F, V, L, I, S, scissors, depth bounds |
//! | [`silhouettes`] | facing bits, signed edges, closed loops, and the cache of (light, caster) pairs |
//! | [`reference`](mod@reference) | ray-cast visibility, slow and exact: the judge of the others (feature `reference`) |
//! | [`render`] | all of wgpu that no technique owns (feature `render`) |
//! | [`techniques`] | one folder each: component, CPU geometry, recorder; the trait and the one list of them |
//! | [`schedule`] | system sets and schedules |
//! | [`bevy_adapter`] | the plugin in a game of Bevy's (feature `bevy`) |
//! | [`plugin`] | the plugin, in a plain `App` and in Bevy's |
//!
//! `shaders/` mirrors the Rust files: `passes/<node>.wgsl` for `render/nodes/<node>.rs`,
//! `techniques/<technique>/<pass>.wgsl` for `techniques/<technique>/`, and `common/` for what both import.
//!
//! # Features
//!
//! | feature | default | gives |
//! | --- | --- | --- |
//! | `render` | yes | the wgpu renderer |
//! | `gltf` | yes | import of glTF 2.0 scenes |
//! | `reference` | no | ray-cast truth on the CPU |
//! | `serde` | no | settings of techniques from files |
//! | `profile` | no | GPU timers |
//! | `bevy` | no | the plugin for Bevy, and Bevy's light visibility as a baseline in `benches/sets` |
//! | `bevy-window` | no | a window for the examples with Bevy |
//!
//! Without any, the ECS core remains: sets, silhouettes and shadow volumes as flat arrays.

#[cfg(feature = "bevy")]
pub mod bevy_adapter;
pub mod conventions;
pub mod geometry;
pub mod plugin;
#[cfg(feature = "reference")]
pub mod reference;
#[cfg(feature = "render")]
pub mod render;
pub mod reports;
pub mod scene;
pub mod schedule;
pub mod sets;
pub mod silhouettes;
pub mod techniques;

/// The snippets of the README, compiled and run as doc tests.
#[cfg(all(doctest, feature = "render", feature = "gltf"))]
#[doc = include_str!("../README.md")]
pub struct Readme;

/// Insides that the tests of this crate look at. No part of the API: they change without notice.
#[doc(hidden)]
pub mod insides {
    #[cfg(feature = "render")]
    pub use crate::render::frame::prepare::{prepare_objects, prepare_techniques};
    /// The mirrors of all WGSL structs but those of wedges.
    #[cfg(feature = "render")]
    pub mod gpu_types {
        pub use crate::render::pools::gpu_types::*;
        pub use crate::techniques::maps::gpu::gpu_types::*;
        pub use crate::techniques::stencil_volume::gpu::gpu_types::*;
    }
    pub use crate::sets::index::boxes::WORD;
    pub use crate::techniques::maps::cascades::split_depths;
    pub use crate::techniques::maps::packing::*;
    pub use crate::techniques::maps::request::{MapRequest, MapShape};
    pub use crate::techniques::penumbra_wedge::component::MAX_SPLIT;
    pub use crate::techniques::penumbra_wedge::geometry::{records, silhouette_layers};
    pub use crate::techniques::penumbra_wedge::wedges::build_penumbra_wedges;
    #[cfg(feature = "render")]
    pub use crate::techniques::registry::recorders::{COMMON, PASSES};
    pub use crate::techniques::shared::extrude::*;

    /// Constants that shaders have too.
    #[cfg(feature = "render")]
    pub mod constants {
        pub use crate::render::nodes::receiver_plane::NO_PLANE;
        pub use crate::techniques::maps::gpu::pipelines::filter_constant;
        pub use crate::techniques::maps::jitter::{DEPTH, RIM, TILE};
        pub use crate::techniques::penumbra_wedge::geometry::shell::RIM as RIM_POINTS;
        pub use crate::techniques::penumbra_wedge::geometry::topology::{
            END, FAR_END, FAR_START, FIRST_APEX, FIRST_RIM,
        };
        pub use crate::techniques::penumbra_wedge::tables::lookup::{ANGLE_STEPS, SECTOR_STEPS};
        pub use crate::techniques::penumbra_wedge::tables::texture::{BORDER_STEPS, NODES};
    }
}

/// What most users name.
pub mod prelude {
    pub use super::plugin::AntumbraPlugin;
    #[cfg(feature = "render")]
    pub use super::render::frame::record::FrameOutputs;
    #[cfg(feature = "render")]
    pub use super::render::{RenderContext, RenderSettings, Renderer, RequestedFeatures};
    pub use super::scene::{
        AlphaMode, Camera, Cell, FaceCulling, InCells, Light, LightKind, LightSelection, Material, MeshData,
        Occluder, Portal, SceneMaterials, SceneMesh, SelectionLayers, ShadowCaster, ShadowReceiver,
    };
    pub use super::schedule::AntumbraSystems;
    pub use super::sets::{FrameLights, ViewportSize};
    pub use super::techniques::{AddTechnique, OmniMap, PenumbraWedge, ShadowMap, StencilVolume};
}
