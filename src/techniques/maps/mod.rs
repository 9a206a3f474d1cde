//! What [`ShadowMap`](super::ShadowMap) and [`OmniMap`](super::OmniMap) share: visibility that is looked up in a picture
//! of the casters from the light.
//!
//! ```text
//! lights with a map ──► request ──► pool plan ──► faces ──► casters of each face ──► what changed ──► draws, resolve
//!   (components)        validated   memory limit  f64       still and moving         revisions        GPU
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | [`settings`] | filters, formats, resolutions, biases; the limits of all maps; what can be wrong with them |
//! | [`request`] | what a light asks for, and what is refused |
//! | [`systems`] | what all techniques with maps bring into the frame |
//! | [`plan`] | who gets how much of the memory |
//! | [`face`] | one picture: its place, its projection, what it can see |
//! | [`movers`] | which casters move, and since when they stand still |
//! | [`cube`], [`cascades`] | the six faces around a light; the boxes that a directional light's maps show |
//! | [`members`] | the faces of a light, and the casters of each |
//! | [`light_map`], [`face_state`] | the map of one light, and what each of its faces shows |
//! | [`cache`] | which faces are drawn anew: the frame's [`Maps`] |
//! | [`packing`] | the packings of squared distance into bytes; twin of the shader |
//! | [`jitter`] | the texture of jittered discs |
//! | `constants`, `map_layouts`, `map_pool`, `map_pipelines`, `map_draws`, `map_recorder`, `node` | the recorder (feature `render`) |
//!
//! **Bias.** No constant is set by hand. A pixel is compared, texel by texel, with the plane of the triangle that it
//! shows, traced along the texel's own ray: on a flat surface both depths are of one point, whatever the angle. What
//! remains is rounding, and a share of a texel by which the plane is raised along its normal for what is not flat.
//! Source: Kozlov 2004, GPU Gems ch. 14, §14.2.3, for the bias in world space scaled by the texel; Isidoro 2006, "Shadow
//! Mapping: GPU-based Tips and Techniques", for the receiver's plane.

pub(crate) mod build_maps;
pub(crate) mod cascades;
pub(crate) mod cube;
pub(crate) mod face;
pub(crate) mod face_state;
#[cfg(feature = "render")]
pub(crate) mod gpu;
pub(crate) mod jitter;
pub(crate) mod light_map;
pub(crate) mod members;
pub(crate) mod movers;
pub(crate) mod packing;
pub(crate) mod plan;
pub(crate) mod request;
pub(crate) mod settings;
pub(crate) mod systems;

pub use build_maps::{MapReport, Maps, build_maps};
pub use face::{FaceProjection, MapFace};
pub use light_map::LightMap;
pub use settings::{
    Cascades, MapBias, MapError, MapFilter, MapFormat, MapResolution, MapSettings, MapSurface,
};

use crate::sets::Needs;

/// What techniques with maps need. Nothing is occluded from their lights: a kept map shows all of set L, and would change
/// with every occluder that moves.
pub(crate) const NEEDS: Needs = Needs {
    receiver_planes: true,
    ..Needs::NOTHING
};
