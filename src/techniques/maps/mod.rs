//! Shadow maps: visibility that is looked up in a picture of the casters from the light.
//! [`ShadowMap`](super::ShadowMap), [`OmniMap`](super::OmniMap) and [`PerspectiveMap`](super::PerspectiveMap) share this
//! code.
//!
//! ```text
//! lights with a map ──► request ──► memory ──► faces ──► casters of a face ──► changes ──► draws, lookup
//!   (components)        validated    limited    in f64     still and moving     revisions       GPU
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `settings` | filters, formats, resolutions, biases; limits of all maps |
//! | `map_error` | why a map is poorer than asked for |
//! | `request` | what a light asks for, and what is refused |
//! | `systems` | what all techniques with maps bring into the frame |
//! | `face` | one picture: position, projection, what it can see |
//! | `matrix_faces` | faces with a matrix: which shows a point, texel sizes, depths of planes; twin of the shader |
//! | `movers` | which casters move, and since when they stand still |
//! | `spot` | the face of a spot light |
//! | `cube`, `cascades` | the six faces around a light; the boxes that a directional light's maps show |
//! | `cascade_range` | the view depths that those boxes share out |
//! | `format_steps` | distances that the bytes of a format cannot tell apart |
//! | `needed_resolution` | the texels that automatic resolution asks for |
//! | `members` | the faces of a light, and the casters of each |
//! | `light_map`, `face_state` | the map of one light, and what each of its faces shows |
//! | `ask_for_maps` | the lights of the frame, and the textures that their maps need |
//! | `build_maps` | the frame's [`Maps`]: which faces are drawn again |
//! | `packing` | the packings of squared distance into bytes; twin of the shader |
//! | `jitter` | the texture of jittered discs |
//! | `debug_lines`, `texels` | the faces as lines, and their texels on a surface |
//! | `gpu` | the recorder (feature `render`) |
//!
//! # Error and cost
//!
//! At 1024², at most 0.35 % of the pixels further than a texel from an edge are wrong on any of 40 models, and none on most,
//! with 15 views and lights each when it was measured. `tests/gpu/maps` draws some of them, and judges 29 scenes that are made to provoke acne, leaks and
//! lost contacts, with 6 kinds of map and up to 6 filters.
//!
//! A map is kept while nothing in it moves: 64 point lights at rest draw no caster at all. The adaptive jittered filter takes 7
//! times fewer taps than all 64 of them.
//!
//! **Bias.** No constant is set by hand. A pixel is compared, texel by texel, with the plane of the triangle
//! that it shows, traced along the texel's own ray. On a flat surface both depths belong to one point,
//! whatever the angle. What remains is rounding, and surfaces that are not flat; for those the plane is
//! raised along its normal by a share of a texel.
//! Source: Kozlov 2004, GPU Gems ch. 14, §14.2.3, for the bias in world space scaled by the texel; Isidoro
//! 2006, "Shadow Mapping: GPU-based Tips and Techniques", for the receiver's plane.

pub(crate) mod ask_for_maps;
pub(crate) mod build_maps;
pub(crate) mod cascade_range;
pub(crate) mod cascades;
pub(crate) mod cube;
pub(crate) mod debug_lines;
pub(crate) mod face;
pub(crate) mod face_state;
pub(crate) mod format_steps;
pub(crate) mod frame_scene;
#[cfg(feature = "render")]
pub(crate) mod gpu;
#[cfg(feature = "render")]
pub(crate) mod jitter;
pub(crate) mod light_map;
pub(crate) mod map_error;
pub(crate) mod matrix_faces;
pub(crate) mod members;
pub(crate) mod movers;
pub(crate) mod needed_resolution;
pub(crate) mod packing;
pub(crate) mod request;
pub(crate) mod settings;
pub(crate) mod spot;
pub(crate) mod systems;
pub(crate) mod texels;

pub use ask_for_maps::ask_for_maps;
pub use build_maps::{Maps, build_maps};
pub use face::{FaceProjection, MapFace};
pub use light_map::LightMap;
pub use map_error::{MapError, MapReport};
pub use settings::{Cascades, MapBias, MapFilter, MapFormat, MapResolution, MapSettings, MapSurface};

use crate::sets::Needs;

/// What techniques with maps need. Nothing is occluded from their lights: a kept map shows all of set L, and would change
/// with every occluder that moves.
pub(crate) const NEEDS: Needs = Needs {
    receiver_planes: true,
    ..Needs::NOTHING
};
