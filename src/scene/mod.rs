//! Components that a user spawns, and where they come from.
//!
//! | component | says |
//! | --- | --- |
//! | [`SceneMesh`], [`SceneMaterials`] | what an entity looks like |
//! | [`ShadowCaster`], [`ShadowReceiver`] | which part it takes in shadows |
//! | [`Occluder`] | whether it may hide others |
//! | [`SelectionLayers`] | which lights select it ([`LightSelection`]) |
//! | [`Cell`], [`InCells`], [`Portal`] | rooms, what is in them, and the openings between them |
//! | [`Light`] | a light; its shadow technique is a component of [`techniques`](crate::techniques) beside it |
//! | [`Camera`], [`IgnoresScale`] | the view |
//! | [`Skin`], [`MorphWeights`] | a mesh that is posed each frame into [`PosedMesh`] |
//! | [`WorldBounds`] | written by us: where it is |
//!
//! Scenes come from code or from glTF files (`gltf_import`), clips of theirs move them ([`animation`]).

pub(crate) mod animation;
pub(crate) mod bounds;
pub(crate) mod camera;
pub(crate) mod caster;
pub(crate) mod cell;
pub(crate) mod changes;
pub(crate) mod churn;
#[cfg(feature = "gltf")]
pub mod gltf_import;
pub(crate) mod light;
pub(crate) mod material;
pub(crate) mod mesh;
pub(crate) mod occluder;
pub(crate) mod placement;
pub(crate) mod pose;
pub(crate) mod tasks;

pub use animation::{AnimationClip, AnimationClips, SceneNodes, apply_animation};
pub use bounds::{LocalBounds, WorldBounds, update_local_bounds, update_world_bounds};
pub use camera::{Camera, IgnoresScale, Orthographic, camera_place};
pub use caster::{FaceCulling, SelectionLayers, ShadowCaster, ShadowReceiver};
pub use cell::{Cell, InCells, Portal};
pub use churn::ObjectChurn;
pub use light::{Light, LightError, LightKind, LightSelection, ShadowedLight};
pub use material::{AlphaMode, Material, SceneMaterials, Texture, TextureSlot, TextureWrap};
pub use mesh::{MeshData, MorphTarget, SceneMesh, Submesh};
pub use occluder::Occluder;
pub use pose::{MorphWeights, PosedMesh, Skin, pose_meshes};
