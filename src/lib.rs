//! Data-oriented shadows and lighting for game engines on `bevy_ecs` and `wgpu`.
//!
//! Each light chooses its own shadow technique. All techniques share the visibility sets, the silhouette
//! extractor, the visibility contract and the light pass.
//!
//! # The frame, as data flow
//!
//! ```text
//! scene components ──► bounds ──► sets F V L I S ──► hull, scissor, depth bounds ──► silhouettes ──► technique geometry
//!   (ECS entities)      SoA          bitsets               per light                   per light×caster     per light
//!                                                                                                             │
//!        ambient + depth (V) ◄───────── shadow maps ◄─────── GPU prepare ◄────────────────────────────────────┘
//!             │
//!             └─► for each light of the frame: mark visibility (S) ─► add its light (I), blend ONE ONE
//!                                                                                     │
//!                                                         tonemap ◄─ blended surfaces ◄┘
//! ```
//!
//! The upper row is the CPU: its steps run in the system sets of
//! [`AntumbraSystems`](schedule::AntumbraSystems), and the last of these sets prepares the GPU. The lower
//! rows are the passes on the GPU: `render/frame/record.rs` calls them in order.
//!
//! # The map
//!
//! Dependencies point one way: a module may use the modules above it in this table and none below it
//! (`tests/core/layers.rs` tests this). [`reference`](mod@reference) stands apart. It uses only `conventions`,
//! `geometry`, `scene` and `sets`, because it must not depend on the code that it judges, and no other module
//! uses it, except `baking`.
//!
//! | folder | holds |
//! | --- | --- |
//! | [`conventions`] | handedness, depth, units, and the constants that shaders share |
//! | [`geometry`] | mathematics on `glam` and `wide`: bounds, planes, frustum, light hull, edge meshes; no ECS |
//! | [`reports`] | messages about refused, skipped or limited things, each with its entity and a remedy |
//! | [`scene`] | components that a user spawns, those of the light model among them; glTF import, poses, animation |
//! | [`sets`] | the sets of seen, lit and casting objects: F, V, L, I, S, scissors, depth bounds |
//! | [`silhouettes`] | facing bits, signed edges, closed loops, and the cache of (light, caster) pairs |
//! | [`debug_lines`] | lines that show sets, silhouettes, hulls, regions and cells |
//! | [`reference`](mod@reference) | ray-cast visibility, slow and exact, with which techniques are compared (feature `reference`) |
//! | [`render`] | all code on wgpu that belongs to no technique (feature `render`) |
//! | [`techniques`] | one folder for each technique: component, CPU geometry, recorder; also the trait and the list of techniques |
//! | [`baking`] | maps of static scenes, cast by the rays of `reference` (feature `reference`) |
//! | [`schedule`] | system sets and schedules |
//! | [`bevy_adapter`] | the connection to Bevy's renderer (feature `bevy`) |
//! | [`plugin`] | the plugin for a plain `App` and for a Bevy game |
//! | [`guide`] | pages on how to use the crate |
//!
//! `shaders/` mirrors the Rust files: `passes/<node>.wgsl` belongs to `render/nodes/<node>.rs`,
//! `techniques/<technique>/<pass>.wgsl` to `techniques/<technique>/`, and `bevy/` to `bevy_adapter/`.
//! `common/` holds files that passes and techniques import.
//!
//! # Features
//!
//! | feature | default | gives |
//! | --- | --- | --- |
//! | `render` | yes | the wgpu renderer |
//! | `gltf` | yes | import of glTF 2.0 scenes; [`scene::gltf_import`] lists what is supported |
//! | `gltf-draco`, `gltf-webp` | yes | compressed meshes and WebP pictures in glTF files |
//! | `gltf-meshopt`, `gltf-basisu` | no | compressed buffer views (needs a C++ compiler) and KTX2 pictures in glTF files |
//! | `reference` | no | ray-cast reference visibility on the CPU |
//! | `serde` | no | reading of techniques' settings from files |
//! | `schema` | no | JSON Schemas of these settings ([`Row::schema`](techniques::Row::schema)) |
//! | `profile` | no | GPU timers, which [`RequestedFeatures`](render::RequestedFeatures) then asks for by default |
//! | `bevy` | no | the plugin for Bevy, with `render`; also Bevy's light visibility as a baseline in `benches/sets` |
//! | `bevy-gizmos` | no | debug lines through Bevy's gizmos, with `bevy` |
//! | `bevy-window` | no | a window for the examples with Bevy, with `bevy-gizmos` |
//!
//! Without any feature the ECS core remains: sets, silhouettes, and the CPU geometry of the techniques.

#[cfg(feature = "reference")]
pub mod baking;
#[cfg(feature = "bevy")]
pub mod bevy_adapter;
pub mod conventions;
pub mod debug_lines;
pub mod geometry;
pub mod guide;
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

/// Internal items that the tests and examples of this crate use. They are not part of the API and change
/// without notice.
#[doc(hidden)]
pub mod insides {
    #[cfg(feature = "render")]
    pub use crate::render::frame::prepare::{prepare_objects, prepare_techniques};
    #[cfg(feature = "render")]
    pub use crate::scene::srgb::linear_from_srgb;
    /// Rust mirrors of all WGSL structs except those of penumbra wedges.
    #[cfg(feature = "render")]
    pub mod gpu_types {
        pub use crate::render::pools::gpu_types::*;
        pub use crate::techniques::maps::gpu::gpu_types::*;
        pub use crate::techniques::occlusion_interval::gpu::gpu_types::*;
        pub use crate::techniques::perspective_map::gpu::gpu_types::*;
        pub use crate::techniques::stencil_volume::gpu::gpu_types::*;
    }
    #[cfg(feature = "bevy")]
    pub use crate::bevy_adapter::forward_views::ForwardGroup;
    pub use crate::sets::index::boxes::WORD;
    pub use crate::techniques::maps::cascades::{DepthRange, split_depths};
    #[cfg(feature = "render")]
    pub use crate::techniques::maps::gpu::constants::map_constants;
    #[cfg(feature = "render")]
    pub use crate::techniques::maps::jitter::disc;
    pub use crate::techniques::maps::packing::*;
    /// Faces of maps with a matrix.
    pub mod matrix_faces {
        pub use crate::techniques::maps::matrix_faces::*;
    }
    pub use crate::techniques::maps::request::{
        LightRequest, MapFaces, MapRequest, MapRequests, MapShape, MapSystems,
    };
    pub use crate::techniques::penumbra_wedge::build_wedges::build_penumbra_wedges;
    pub use crate::techniques::penumbra_wedge::component::MAX_SPLIT;
    pub use crate::techniques::penumbra_wedge::geometry::{records, silhouette_layers};
    #[cfg(feature = "render")]
    pub use crate::techniques::registry::recorders::{COMMON, PASSES};
    pub use crate::techniques::shared::extrude::*;

    /// Records and CPU twins of smoothies.
    pub mod smoothies {
        pub use crate::techniques::maps::request::Beside;
        pub use crate::techniques::smoothie::{expand::*, outline::*, records::*, shade::*};
    }

    /// Records and CPU twins of occlusion textures.
    pub mod occlusion_textures {
        pub use crate::techniques::occlusion_texture::{
            face::*, filter::*, fit::*, kernel::*, light_slices::*, records::*, scene_box::*, sliced_light::*,
        };
    }

    /// Constants that shaders define with the same values.
    #[cfg(feature = "render")]
    pub mod constants {
        pub use crate::render::nodes::receiver_plane::NO_PLANE;
        pub use crate::techniques::maps::gpu::pipelines::filter_constant;
        pub use crate::techniques::maps::jitter::{DEPTH, RIM, TILE};
        pub use crate::techniques::occlusion_texture::gpu::textures::RADIX;
        pub use crate::techniques::penumbra_wedge::geometry::shell::RIM as RIM_POINTS;
        pub use crate::techniques::penumbra_wedge::geometry::topology::{
            END, FAR_END, FAR_START, FIRST_APEX, FIRST_RIM,
        };
        pub use crate::techniques::penumbra_wedge::tables::lookup::{
            ANGLE_STEPS, SECTOR_STEPS, entries as lookup_entries,
        };
        pub use crate::techniques::penumbra_wedge::tables::texture::{BORDER_STEPS, NODES};
        pub use crate::techniques::perspective_map::grounds::{BLUR_REACH, MOST_GROUNDS};
    }
}

/// The names that most users need.
pub mod prelude {
    pub use super::plugin::AntumbraPlugin;
    #[cfg(feature = "render")]
    pub use super::render::frame::record::FrameOutputs;
    #[cfg(feature = "render")]
    pub use super::render::{RenderContext, RenderSettings, Renderer, RequestedFeatures};
    pub use super::scene::{
        AlphaMode, Camera, Cell, Cookie, CookieImage, CulledCasters, FaceCulling, InCells, Light, LightKind,
        LightPath, LightProfile, LightSelection, Material, MeshData, Occluder, Portal, SceneMaterials,
        SceneMesh, SelectionLayers, ShadowCaster, ShadowReceiver,
    };
    pub use super::schedule::AntumbraSystems;
    pub use super::sets::{FrameLights, ViewportSize};
    pub use super::techniques::{
        AddTechnique, OcclusionInterval, OcclusionTexture, OmniMap, PenumbraWedge, PerspectiveMap, ShadowMap,
        Smoothie, StencilVolume,
    };
}
