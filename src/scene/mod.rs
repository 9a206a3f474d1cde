//! Components that a user spawns, and the import and animation of scenes.
//!
//! | component | says |
//! | --- | --- |
//! | [`SceneMesh`], [`SceneMaterials`] | what an entity looks like |
//! | [`ShadowCaster`], [`ShadowReceiver`] | whether an entity blocks light, and whether it shows shadows |
//! | [`LeftOutSubmeshes`] | which submeshes of a caster cast nothing; written by this crate |
//! | [`BlurredGround`] | whether the shadows on a receiver are blurred |
//! | [`Occluder`] | whether an entity may hide others |
//! | [`SelectionLayers`] | which lights select an entity ([`LightSelection`]) |
//! | [`Cell`], [`InCells`], [`Portal`] | rooms, what is in them, and the openings between them |
//! | [`Light`] | a light; its shadow technique is a further component ([`techniques`](crate::techniques)) |
//! | [`LightShape`], [`LightDistance`], [`LightWeights`], [`ShadowTint`], [`ShadowOrigin`], [`ShadowSoftness`], [`Cookie`], [`LightProfile`] | the light model (`light_model`): what an artist sets on a light |
//! | [`LightPath`] | the path along which a light moves, such as the sun's through a day |
//! | [`SurfaceWeights`] | how an object answers ambient, diffuse and specular light |
//! | [`Camera`], [`IgnoresScale`] | the view, and whether it leaves the scale of its transform out |
//! | [`Skin`], [`MorphWeights`] | how a mesh is posed each frame into [`PosedMesh`] |
//! | [`WorldBounds`] | where an entity is; written by this crate |
//!
//! Scenes come from code or from glTF files (`gltf_import`). The animation clips of a file move its entities
//! ([`AnimationClip`], [`apply_animation`]).

pub(crate) mod animation;
pub(crate) mod bounds;
pub(crate) mod bounds_components;
pub(crate) mod camera;
pub(crate) mod caster;
pub(crate) mod cell;
pub(crate) mod changes;
pub(crate) mod churn;
#[cfg(feature = "gltf")]
pub mod gltf_import;
pub(crate) mod ground;
pub(crate) mod light;
pub(crate) mod light_model;
pub(crate) mod light_path;
pub(crate) mod light_path_check;
pub(crate) mod material;
pub(crate) mod mesh;
pub(crate) mod occluder;
pub(crate) mod placement;
pub(crate) mod pose;
mod pose_components;
#[cfg(any(feature = "gltf", feature = "render"))]
pub(crate) mod srgb;
pub(crate) mod tasks;
pub(crate) mod uncleared;

pub use animation::{AnimationClip, AnimationClips, SceneNodes, apply_animation};
pub use bounds::{update_local_bounds, update_world_bounds};
pub use bounds_components::{ExtraBounds, LocalBounds, WorldBounds};
pub use camera::{Camera, IgnoresScale, Orthographic, camera_place};
pub(crate) use caster::Submeshes;
pub use caster::{
    CulledCasters, FaceCulling, LeftOutSubmeshes, SelectionLayers, ShadowCaster, ShadowReceiver,
};
pub use cell::{Cell, InCells, Portal};
pub use churn::ObjectChurn;
pub use ground::BlurredGround;
pub use light::{Light, LightError, LightKind, LightSelection};
pub use light_model::{
    BarnMap, Cookie, CookieError, CookieImage, CookieImageError, LayerNames, LightDistance, LightModel,
    LightModelFault, LightModelParts, LightProfile, LightShape, LightTextures, LightWeights,
    LoadProfileError, ProfileError, ProfileFault, ProfileTable, ShadowOrigin, ShadowSoftness, ShadowTint,
    SurfaceWeights, TooManyLayers,
};
pub use light_path::{LightPath, PathPoint};
pub use light_path_check::PathError;
pub use material::{AlphaMode, Material, SceneMaterials, Texture, TextureSlot, TextureWrap};
pub use mesh::{MeshData, MorphTarget, SceneMesh, Submesh};
pub use occluder::Occluder;
pub use pose::pose_meshes;
pub use pose_components::{MorphWeights, PosedMesh, Skin};
