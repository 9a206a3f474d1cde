//! The light model: what an artist sets on a light beside its place, colour and technique. It scales what a
//! light gives at a surface. It is no shadow technique, and works under each of them, with none, in frames of a
//! host and in Bevy.
//!
//! Each component is optional and stands on the entity of a [`Light`](super::Light), except
//! [`SurfaceWeights`], which stands on an object. A component at its default changes nothing. A component with
//! numbers that cannot be used is left out and reported ([`LightModelFault`]); the light still shines.
//!
//! | component | says | joins the frame in |
//! | --- | --- | --- |
//! | [`LightShape`] | barn doors: the superellipse in which the light shines | the light function, the volume |
//! | [`BarnMap`] | that the shape is looked up in a texture, not computed | the light function |
//! | [`LightDistance`] | the depths between which the light shines | the light function, the volume |
//! | [`LightWeights`], [`SurfaceWeights`] | weights of ambient, diffuse and specular light | the light pass |
//! | [`Cookie`] | a picture before the light, which colours and shapes it | the light textures |
//! | [`LightProfile`] | intensity by direction, as measured (IES, EULUMDAT) | the light textures |
//! | [`ShadowTint`] | colour and darkness of the light's shadows | the light pass |
//! | [`ShadowOrigin`] | the place from which shadows are cast, if it is not the light's | the sets, techniques |
//! | [`ShadowSoftness`] | the extent that shadows are cast with, if it is not the light's | the sets, techniques |
//!
//! [`LightSelection`](super::LightSelection) says which objects a light lights, which cast for it, and which show its
//! shadows. [`LayerNames`] gives names to the layers that its masks select.
//!
//! [`LightModel`] gathers the usable parts of one light. The formulas of shapes and distances are here too, as
//! the twins of `shaders/common/light_shape.wgsl`.
//!
//! Source: Pellacini & Vidimce 2004, "Cinematic Lighting", GPU Gems ch. 10, after Barzel 1997, "Lighting
//! Controls for Computer Cinematography".

pub(crate) mod barn_map;
pub(crate) mod cookie;
pub(crate) mod distance;
pub(crate) mod layer_names;
pub(crate) mod model;
pub(crate) mod profile;
pub(crate) mod shadow;
pub(crate) mod shape;
pub(crate) mod textures;
pub(crate) mod weights;

pub use barn_map::BarnMap;
pub use cookie::{Cookie, CookieError, CookieImage, CookieImageError};
pub use distance::LightDistance;
pub use layer_names::{LayerNames, TooManyLayers};
pub use model::{LightModel, LightModelFault, LightModelParts};
pub use profile::{LightProfile, LoadProfileError, ProfileError, ProfileFault, ProfileTable};
pub use shadow::{ShadowOrigin, ShadowSoftness, ShadowTint};
pub use shape::LightShape;
pub use textures::LightTextures;
pub use weights::{LightWeights, SurfaceWeights};
