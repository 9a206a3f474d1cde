//! The plugin in a Bevy game (feature `bevy`).
//!
//! ```text
//!  main world                     render world
//!  meshes ─► MeshLibrary ──┐
//!  (assets)                ├─ extract ─► Mirror of each camera ─► sets, silhouettes, buffers ─► Core3d: base, lights
//!  transforms, lights, … ──┘             (a World of our core components)
//! ```
//!
//! [`AntumbraPlugin`](crate::plugin::AntumbraPlugin), added before or after `DefaultPlugins`, installs the
//! adapter. A camera with [`AntumbraCamera`] shows the shadows of every *managed* light: a `PointLight`,
//! `SpotLight`, `DirectionalLight` or `RectLight` with a component of [`techniques`](crate::techniques)
//! beside it. Bevy's own shader functions compute the light's brightness, colour, cookie and falloff. This
//! crate only computes its visibility.
//!
//! # What Bevy does, and what this crate does
//!
//! | subject | behaviour |
//! | --- | --- |
//! | cameras without [`AntumbraCamera`] | rendered by Bevy alone: forward or deferred as they were, with their MSAA |
//! | opaque and alpha-masked meshes in marked cameras | drawn deferred, lit by Bevy's functions, shadowed by this crate |
//! | materials whose `opaque_render_method` is `Forward`, and those without a deferred shader | drawn forward, as for other cameras; materials without a deferred shader are named in the log |
//! | forward, transparent and transmissive meshes, volumetric fog | lit by Bevy, and shadowed by Bevy's maps if `shadow_maps_enabled` is on; the meshes cast shadows of this crate |
//! | lights without a technique | lit and shadowed by Bevy |
//! | `NotShadowCaster`, `NotShadowReceiver` | work as in Bevy |
//! | `RenderLayers` of a mesh | the mesh blocks a light if they share a layer; layers from 31 on count as one |
//! | `Visibility` | a hidden mesh casts nothing, a hidden light does not shine |
//! | `RenderLayers` of a light | work as in Bevy: if the light and a camera share a layer, the light lights everything that the camera sees |
//! | [`LightSelection`](crate::scene::LightSelection) on a light | restricts the layers of the meshes that the light lights, of those that block it, and of those that show its shadows |
//! | components of the light model on a light ([`LightShape`](crate::scene::LightShape), [`ShadowTint`](crate::scene::ShadowTint) …) | shape what Bevy's functions give on opaque surfaces, with a technique or without one; a light with a model is managed, and has no shadow but that of its technique |
//! | [`LightWeights::ambient`](crate::scene::LightWeights) of a `RectLight`, [`SurfaceWeights`](crate::scene::SurfaceWeights) | have no effect: Bevy's rectangles give no irradiance to a surface that faces them, and Bevy's G-buffer holds no weights |
//! | `Camera`s | any number, perspective or orthographic, with render targets, viewports, TAA jitter and fog; marked cameras have no MSAA, because deferred shading has one sample a pixel |
//!
//! The adapter does not change `DefaultOpaqueRendererMethod`. A material of another type than
//! `StandardMaterial` is deferred for marked cameras if it has a deferred shader of its own, or no shaders of
//! its own. An extension draws in both ways if it returns the same shader from `fragment_shader` and
//! `deferred_fragment_shader`, and the shader ends with
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
//! Leave `shadow_maps_enabled` of managed lights off. If it is on, Bevy renders its maps too, although no
//! opaque surface reads them. The adapter creates no Bevy views.
//!
//! Alpha-masked casters block light with their whole triangles. Volumes and wedges always do this; in Bevy
//! maps do it too, because the adapter does not read the textures of Bevy's materials. Meshes with several
//! levels of detail (`VisibilityRange`) cast with all levels.
//!
//! | file | subject |
//! | --- | --- |
//! | `install`, `systems`, `settings` | registration, order of systems, settings |
//! | `camera`, `camera_warnings` | the marker, the components that it adds and removes, warnings |
//! | `deferral`, `deferred_views` | the choice of materials that are deferred for marked cameras, and their queues |
//! | `report` | reports in the game's [`Reports`](crate::reports::Reports) and in the log |
//! | `mesh_convert`, `mesh_library`, `refused` | meshes, made ready on other threads |
//! | `surfaces` | opaque and see-through objects |
//! | `mirror`, `entity_map`, `techniques` | the scene of one camera, and the techniques that it knows |
//! | `sync`, `sync_objects`, `sync_lights`, `sync_models`, `light_convert`, `projection` | copying of the game's changes to the mirrors |
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
pub(crate) mod sync_models;
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
