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
//! | materials whose `opaque_render_method` is `Forward`, and those without a deferred shader | drawn forward, as for other cameras, and shadowed by this crate (see below) |
//! | `StandardMaterial`s with features that Bevy's G-buffer does not hold, meshes with a `Lightmap` | drawn forward, too (see below) |
//! | `ContactShadows` on a marked camera | darken the light of managed lights whose `contact_shadows_enabled` is on, as in Bevy |
//! | transparent and transmissive meshes, volumetric fog | lit by Bevy, and shadowed by Bevy's maps if `shadow_maps_enabled` is on; the meshes cast shadows of this crate |
//! | lights without a technique | lit and shadowed by Bevy |
//! | `PointLight` | a sphere if its `radius` is greater than 0, which techniques with soft shadows use; else a point |
//! | `SpotLight` | a point: its `radius` is ignored, and [`ShadowSoftness`](crate::scene::ShadowSoftness) gives it an extent |
//! | `DirectionalLight` | has no extent; [`OcclusionTexture`](crate::techniques::OcclusionTexture) and [`Smoothie`](crate::techniques::Smoothie) have a setting for it |
//! | `NotShadowCaster`, `NotShadowReceiver` | work as in Bevy |
//! | `RenderLayers` of a mesh | the mesh blocks a light if they share a layer; layers from 31 on count as one |
//! | `Visibility` | a hidden mesh casts nothing, a hidden light does not shine |
//! | `RenderLayers` of a light | work as in Bevy: if the light and a camera share a layer, the light lights everything that the camera sees |
//! | [`LightSelection`](crate::scene::LightSelection) on a light | restricts the layers of the meshes that the light lights, of those that block it, and of those that show its shadows |
//! | components of the light model on a light ([`LightShape`](crate::scene::LightShape), [`ShadowTint`](crate::scene::ShadowTint) …) | shape what Bevy's functions give on opaque surfaces, with a technique or without one; a light with a model is managed, and has no shadow but that of its technique |
//! | [`SurfaceWeights`](crate::scene::SurfaceWeights) on a mesh | weight what managed lights give to it, if it is opaque and drawn deferred; while one that is seen has them, all managed lights of the view take the slower pass that tells diffuse light and highlights apart |
//! | [`LightWeights::ambient`](crate::scene::LightWeights) of a `RectLight` | has no effect: Bevy's rectangles give no irradiance to a surface that faces them |
//! | `Camera`s | any number, perspective or orthographic, with render targets, viewports, TAA jitter and fog; marked cameras have no MSAA, because deferred shading has one sample a pixel |
//! | `Camera::invert_culling`, for a camera whose scale mirrors | warned of on a marked camera, because Bevy's prepasses ignore it and cull the faces towards the camera |
//! | `VisibilityRange` | a level of detail that the camera does not draw casts nothing; of two levels that fade into each other the one that is drawn more casts |
//! | alpha-masked and blended casters | maps leave out the holes, volumes and wedges do not (see below) |
//! | [`Cell`](crate::scene::Cell), [`Portal`](crate::scene::Portal), [`InCells`](crate::scene::InCells), [`Occluder`](crate::scene::Occluder) | hide objects from lights and from the light passes of marked cameras; Bevy still draws every object |
//! | negative and zero scales | meshes are drawn as Bevy draws them, and block light as they are drawn |
//! | `RectLight` | its size is multiplied by its transform's scale, for light and shadow; where a scale mirrors it, it shines to the side that Bevy lights, and a mesh on the same entity casts as if it were mirrored along local Z |
//! | `MainPassResolutionOverride` | shadows are computed in the part of the target in use |
//! | [`LightClearance`](crate::sets::LightClearance), [`OcclusionSettings`](crate::sets::OcclusionSettings), [`MapSettings`](crate::techniques::maps::MapSettings) | resources of the game, which all marked cameras follow |
//!
//! Leave `shadow_maps_enabled` of managed lights off, unless transparent meshes shall have shadows. If it is on,
//! Bevy renders its maps too; deferred surfaces do not read them, and forward ones are darkened twice. The
//! adapter creates no Bevy views.
//!
//! # Materials of other types
//!
//! The adapter does not change `DefaultOpaqueRendererMethod`. A material of another type than
//! `StandardMaterial` is deferred for marked cameras if it has a deferred shader of its own, or no shaders of
//! its own. An extension draws in both ways if it returns the same shader from `fragment_shader` and
//! `deferred_fragment_shader`, and the shader ends as below. `examples/bevy_extension.rs` is such a material,
//! whole.
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
//! # Casters with holes
//!
//! Maps read the alpha of Bevy's textures on the device: [`OmniMap`](crate::techniques::OmniMap) and
//! [`ShadowMap`](crate::techniques::ShadowMap) leave the holes of alpha-masked `StandardMaterial`s out of
//! shadows, and of blended ones what Bevy's own maps leave out (alpha below 0.05). Give lights that shine
//! through leaves and fences one of these techniques. Volumes and wedges are made of triangles, so under them
//! such casters block light with their whole triangles; the log says so once for each material. A material
//! whose whole surface is a hole casts nothing under every technique. Holes that another type of material cuts
//! are not known to the adapter. Maps follow a texture whose `Image` changes; pixels that the GPU writes into a
//! texture are not noticed, and maps that are kept show its holes as they were.
//!
//! # What deferred drawing loses
//!
//! Bevy's G-buffer has eight bits each for colour, roughness, metallic, reflectance and occlusion, and 16 steps for a
//! clearcoat and for its roughness. It has no anisotropy, no coloured `specular_tint`, no clearcoat with a roughness above 0.5
//! or with normals other than those of the base. A `StandardMaterial` with such a feature whose method is `Auto` stays
//! forward. It is deferred, and loses the feature, if its method is `Deferred` or the device has only four bind groups.
//! Materials of other types are not examined: give an extension no deferred shader if its base has such a feature.
//!
//! Bevy's deferred shading does not know which surfaces have a lightmap. It adds all lights to them, also those whose light
//! the lightmap holds. So meshes with a `Lightmap` stay forward, unless the method of their material is `Deferred`.
//!
//! # Forward meshes
//!
//! Opaque and alpha-masked meshes that stay forward show the shadows of this crate too: the light pass keeps the
//! visibility of each managed light in a layer of an array, and a copy of the material's shader looks it up by
//! override where Bevy's light functions are called. Where a light is seen wholly, the picture equals Bevy's
//! forward picture bit for bit. What limits it:
//!
//! - The masks are the fifth bind group, because Bevy's materials use four. WebGPU guarantees no fifth. On such a
//!   device forward meshes are lit without shadows of this crate, and the log names their materials.
//! - The material's shader must be WGSL, and must call Bevy's lighting in its own source, because overrides apply only to
//!   the root module. Other shaders keep Bevy's light.
//! - The mesh is in the depth prepass (`enable_prepass`), because a mask belongs to the surface that is seen. Nor
//!   is there a mask for the back of a mesh: materials with `diffuse_transmission` keep Bevy's light.
//! - A view keeps 16 of the lights that light something in it, in four bytes a pixel each. Further lights are lit
//!   without shadows. Views without forward meshes keep nothing.
//!
//! Forward meshes show the shape, the distances, the cookie and the profile of a light in 256 steps. Of a
//! [`ShadowTint`](crate::scene::ShadowTint) they show darkness and colour, on highlights too, and a shadow is nowhere
//! brighter than the light. They do not show [`LightWeights`](crate::scene::LightWeights) and
//! [`SurfaceWeights`](crate::scene::SurfaceWeights), because Bevy's functions
//! give diffuse light and highlights in one sum.
//!
//! Transparent and transmissive meshes show no shadows of this crate. They are not in the depth prepass, and
//! several lie behind each other at a pixel, so the mask of a pixel is not theirs.
//!
//! | file | subject |
//! | --- | --- |
//! | `install`, `systems`, `settings` | registration, order of systems, settings |
//! | `camera`, `camera_warnings` | the marker, the components that it adds and removes, warnings |
//! | `shared_targets` | prepass textures of cameras that share a target but not its number of samples |
//! | `forward_views`, `forward_shaders`, `forward_masks` | shadows of meshes that stay forward |
//! | `deferral`, `deferred_views` | the choice of materials that are deferred for marked cameras, and their queues |
//! | `report` | reports in the game's [`Reports`](crate::reports::Reports) and in the log |
//! | `diagnostics` | counts and times in Bevy's diagnostics |
//! | `gizmos` | sets, silhouettes, hulls, regions, cells and techniques as Bevy's gizmos |
//! | `mesh_convert`, `mesh_library`, `refused` | meshes, made ready on other threads |
//! | `still_scene` | a copy of what stands still, to bake maps from |
//! | `surfaces`, `cut_outs` | opaque and see-through objects, holes by alpha |
//! | `ranges` | levels of detail |
//! | `mirror`, `entity_map`, `techniques` | the scene of one camera, and the techniques that it knows |
//! | `sync`, `sync_objects`, `sync_cells`, `sync_lights`, `sync_models`, `sync_settings`, `light_convert`, `projection` | copying of the game's changes to the mirrors |
//! | `prepare`, `prepare_lights`, `draw_resources`, `view_state`, `view_groups`, `pipelines`, `pass` | the frame on the GPU |

pub(crate) mod camera;
pub(crate) mod camera_warnings;
pub(crate) mod cut_outs;
pub(crate) mod deferral;
pub(crate) mod deferred_views;
pub(crate) mod diagnostics;
pub(crate) mod draw_resources;
pub(crate) mod entity_map;
pub(crate) mod forward_masks;
pub(crate) mod forward_shaders;
pub(crate) mod forward_views;
#[cfg(feature = "bevy-gizmos")]
pub(crate) mod gizmos;
pub(crate) mod install;
pub(crate) mod light_convert;
pub(crate) mod mesh_convert;
pub(crate) mod mesh_library;
pub(crate) mod mirror;
pub(crate) mod pass;
pub(crate) mod pipelines;
pub mod prelude;
pub(crate) mod prepare;
pub(crate) mod prepare_lights;
pub(crate) mod projection;
pub(crate) mod ranges;
pub(crate) mod refused;
pub(crate) mod report;
pub(crate) mod settings;
pub(crate) mod shared_targets;
pub(crate) mod still_scene;
pub(crate) mod surfaces;
pub(crate) mod sync;
pub(crate) mod sync_cells;
pub(crate) mod sync_lights;
pub(crate) mod sync_models;
pub(crate) mod sync_objects;
pub(crate) mod sync_settings;
pub(crate) mod systems;
pub(crate) mod techniques;
pub(crate) mod view_groups;
pub(crate) mod view_state;

pub use camera::AntumbraCamera;
pub use diagnostics::AntumbraDiagnosticsPlugin;
#[cfg(feature = "bevy-gizmos")]
pub use gizmos::{AntumbraGizmoLines, AntumbraGizmos, AntumbraGizmosPlugin};
pub use mesh_convert::MeshRefusal;
pub use mesh_library::{MeshEntry, MeshLibrary, ReadyMesh};
pub use mirror::{HostBounds, HostEntity, HostLight, Mirror, Mirrors};
pub use refused::RefusedMeshes;
pub use settings::AntumbraSettings;
pub use still_scene::still_scene;
pub use systems::{AntumbraExtractSystems, AntumbraMainSystems, AntumbraRenderSystems};
