//! The plugin in a game of Bevy's (feature `bevy`).
//!
//! ```text
//!  main world                     render world
//!  meshes ─► MeshLibrary ──┐
//!  (assets)                ├─ extract ─► Mirror of each camera ─► sets, silhouettes, buffers ─► Core3d: base, lights
//!  transforms, lights, … ──┘             (a World of our core components)
//! ```
//!
//! [`AntumbraPlugin`](crate::plugin::AntumbraPlugin), added before or after `DefaultPlugins`, installs it. A camera with
//! [`AntumbraCamera`] shows the shadows of every *managed* light: a `PointLight`, `SpotLight`, `DirectionalLight` or
//! `RectLight` with a component of [`techniques`](crate::techniques) beside it. Its brightness, colour, cookie and falloff
//! stay Bevy's, computed by Bevy's own shader functions; only its visibility is ours.
//!
//! # What is Bevy's, and what is ours
//!
//! | | |
//! | --- | --- |
//! | cameras without [`AntumbraCamera`] | Bevy's in everything: forward or deferred as they were, with their MSAA |
//! | opaque and alpha-masked meshes in marked cameras | drawn deferred, lit by Bevy's functions, shadowed by us |
//! | materials whose `opaque_render_method` is `Forward`, and those without a deferred shader | forward, as for other cameras; the latter are named in the log |
//! | forward, transparent and transmissive meshes, volumetric fog | lit by Bevy, shadowed by Bevy's maps if `shadow_maps_enabled` is left on; they cast our shadows |
//! | lights without a technique | Bevy's |
//! | `NotShadowCaster`, `NotShadowReceiver` | as Bevy has them |
//! | `RenderLayers` | a light is blocked by meshes that share a layer with it; layers from 31 on count as one |
//! | `Visibility` | a hidden mesh casts nothing, a hidden light does not shine |
//! | `RenderLayers` of a light | as Bevy has them, it lights all that a camera sees with which it shares a layer |
//! | [`LightSelection`](crate::scene::LightSelection) on a light | of the meshes' layers, those that it lights and those that block it |
//! | `Camera`s | any number, perspective or orthographic; render targets, viewports, jitter of TAA, fog; without MSAA if marked, because deferred shading has one sample a pixel |
//!
//! `DefaultOpaqueRendererMethod` stays what it is. A material of another type than `StandardMaterial` is deferred for marked
//! cameras if it has a deferred shader of its own, or no shaders of its own: an extension draws in both ways if it returns
//! one shader from `fragment_shader` and `deferred_fragment_shader`, and ends it with
//!
//! ```wgsl
//! #ifdef PREPASS_PIPELINE
//!     return deferred_output(in, pbr_input);          // bevy_pbr::pbr_deferred_functions
//! #else
//!     var out: FragmentOutput;                        // bevy_pbr::forward_io
//!     out.color = main_pass_post_lighting_processing(pbr_input, apply_pbr_lighting(pbr_input));
//!     return out;
//! #endif
//! ```
//!
//! Leave `shadow_maps_enabled` of managed lights off: Bevy would render its maps all the same, and nothing opaque reads
//! them. We create no views of Bevy's.
//!
//! Alpha-masked casters block whole in volumes and wedges, and so do they in maps here, whose textures are Bevy's. Meshes
//! of several levels of detail (`VisibilityRange`) cast with all of them.
//!
//! | file | subject |
//! | --- | --- |
//! | `install`, `systems`, `settings` | registration and order |
//! | `camera`, `camera_warnings` | the marker, what it brings and takes back; warnings |
//! | `deferral`, `deferred_views` | which materials are deferred for marked cameras, and their queues |
//! | `report` | what is wrong, in the game's [`Reports`](crate::reports::Reports) and in the log |
//! | `mesh_convert`, `mesh_library`, `refused` | meshes, made ready on other threads |
//! | `surfaces` | which objects one looks through |
//! | `mirror`, `entity_map`, `techniques` | the scene of one camera |
//! | `sync`, `sync_objects`, `sync_lights`, `light_convert`, `projection` | what the game changed |
//! | `prepare`, `view_state`, `view_groups`, `pipelines`, `pass` | the frame on the GPU |

pub(crate) mod camera;
pub(crate) mod camera_warnings;
pub(crate) mod deferral;
pub(crate) mod deferred_views;
pub(crate) mod entity_map;
pub(crate) mod install;
pub(crate) mod light_convert;
pub(crate) mod mesh_convert;
pub(crate) mod mesh_library;
pub(crate) mod mirror;
pub(crate) mod pass;
pub(crate) mod pipelines;
pub mod prelude;
pub(crate) mod prepare;
pub(crate) mod projection;
pub(crate) mod refused;
pub(crate) mod report;
pub(crate) mod settings;
pub(crate) mod surfaces;
pub(crate) mod sync;
pub(crate) mod sync_lights;
pub(crate) mod sync_objects;
pub(crate) mod systems;
pub(crate) mod techniques;
pub(crate) mod view_groups;
pub(crate) mod view_state;

pub use camera::AntumbraCamera;
pub use mesh_convert::MeshRefusal;
pub use mesh_library::{MeshEntry, MeshLibrary, ReadyMesh};
pub use mirror::{HostBounds, HostEntity, HostLight, Mirror, Mirrors};
pub use refused::RefusedMeshes;
pub use settings::AntumbraSettings;
pub use systems::{AntumbraExtractSystems, AntumbraMainSystems, AntumbraRenderSystems};
