//! Occlusion interval maps: soft shadows of a static scene under a light that moves along a path, such as the sun's.
//!
//! ```text
//! once:     scene and path ──► baking ──► maps: for each texel, when it sees the light
//! a frame:  time and width ──► window of time ──► share of the window in which four texels see it ──► blended: visibility
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `component` | [`OcclusionInterval`], which a user sets on a light; the system that moves the light |
//! | `technique` | how the component joins the frame |
//! | `intervals` | the mathematics; twin of the shader |
//! | `steps` | sets of steps of the path: which windows are wholly lit or dark (feature `render`) |
//! | `maps`, `maps_check` | maps in memory |
//! | `files`, `read`, `manifest`, `maps_error` | maps on disk |
//! | `library` | the maps of a world, and the folders that they are read from |
//! | `scenes`, `matching`, `fault` | which maps a light has, which objects are in them, and why a light has none |
//! | `surface` | how an object is recognized |
//! | `gpu` | the recorder (feature `render`) |
//!
//! Maps are baked by `antumbra::baking` (feature `reference`) or `examples/bake`.
//!
//! **Light.** A directional light on an arc or with the sun's path, or a point or spot light on a polyline. It is a linear
//! light: a stretch of its path, of the *width* asked for. Shadows are soft along the path and hard across it. Width and
//! time are settings of the frame. At the ends of an open path the stretch is cut; a closed path wraps around.
//!
//! **Exactness.** Maps know the path in 256 steps, so edges are right to 1/256 of the path in time, and to a texel in space.
//! Texels are evaluated before they are blended, which is smooth where interpolated edges would be nonsense. Charts end at
//! creases, so texels of surfaces that face elsewhere are never blended. A texel that lies below an object is dark, and
//! blends into its neighbours: within a texel of a contact, shadows are too large.
//! Against a ray-traced linear light at 20 times of a day, off the band of a texel, the mean RMSE is 0.003 in `interior` at
//! 8 texels a metre and 0.019 in `town_A` at 2, where one or two pixels are wrong at some times (tests `by_hand`).
//!
//! **What moves.** Maps hold what stood still. An object that is not in the maps shows no shadow of the light and casts
//! none, unless the light has a second technique, such as a [`ShadowMap`](crate::techniques::ShadowMap) or a
//! [`StencilVolume`](crate::techniques::StencilVolume) beside the [`OcclusionInterval`]. On surfaces in the maps, the darker of
//! both counts: what the maps hold, and the shadows that the second technique makes of the objects that are not in the maps. On
//! all other receivers the second technique shows the shadows of all casters. An object counts as a whole: if one of its
//! submeshes is not in the maps, the second technique shadows all of them, and by all of them.
//!
//! The second technique casts from the point of the path where the light stands, so its shadows are as soft as it makes them,
//! whatever the width. It adds no pass while nothing that is not in the maps is seen or shadows what is seen. Otherwise it
//! costs what it costs on a light of its own, up to twice: once for surfaces in the maps, and once for the others.
//!
//! While the maps cannot be used, the second technique shadows everything. So it does after an object that was baked has moved:
//! bake only what stays. That memory for the textures is short is known one frame later.
//!
//! **Night.** While the sun is below the horizon, it lights nothing that shows shadows, whether that is in the maps or not.
//! Objects that show no shadows are lit from below.
//!
//! **When the scene changes.** Surfaces are recognized by their triangles and their place. If one that was baked is gone, has
//! moved, or blocks the light now and did not then (or the reverse), the maps are refused and reported, and the light shines
//! with the shadows of its second technique, or without any. Objects that come or go elsewhere change nothing.
//!
//! **Several lights** on the same path may name the same maps. Their textures exist once, and count once towards
//! [`TextureMemory`](crate::techniques::TextureMemory).
//!
//! **Two-sided surfaces** hold what both of their sides see. A window of time in which the light passes behind such a
//! surface counts as seen, though the side in view does not see all of it.
//!
//! **Cost.** Receivers are drawn once more, for depth and four texels a pixel for each pair that its page has, up to the first
//! pair that is not full. Their triangles share vertices within a chart. Runs of 128 triangles that are wholly lit in the
//! window of time are not drawn. If more are wholly dark, and all receivers in view are in the maps, those are not drawn
//! instead. A host in whose pictures the light also falls on other things, such as Bevy, leaves out lit ones only.
//!
//! Beside the same light without a shadow, a frame of `interior` takes 1.05 to 1.2 times the processor time on a software
//! driver: under a sun, nearly all of it is dark. It takes 1.5 times if all of its 510,000 triangles are drawn
//! (`cost_of_a_frame_by_hand`). Memory: 8 bytes a texel and pair, and 72 bytes on the processor for each run.
//!
//! Source: Donnelly & Demers 2004, "Generating Soft Shadows Using Occlusion Interval Maps", GPU Gems, chapter 13.

pub(crate) mod component;
pub(crate) mod fault;
#[cfg(any(feature = "render", feature = "reference"))]
pub(crate) mod files;
#[cfg(feature = "render")]
pub(crate) mod gpu;
pub(crate) mod intervals;
pub(crate) mod library;
#[cfg(any(feature = "render", feature = "reference"))]
pub(crate) mod manifest;
pub(crate) mod maps;
pub(crate) mod maps_check;
#[cfg(any(feature = "render", feature = "reference"))]
pub(crate) mod maps_error;
pub(crate) mod matching;
#[cfg(any(feature = "render", feature = "reference"))]
pub(crate) mod read;
pub(crate) mod scenes;
#[cfg(feature = "render")]
pub(crate) mod steps;
pub(crate) mod surface;
pub(crate) mod technique;

pub use component::OcclusionInterval;
pub use fault::IntervalFault;
#[cfg(any(feature = "render", feature = "reference"))]
pub use files::MANIFEST;
pub use intervals::{
    Interval, Intervals, LEAST_WIDTH, PER_PAIR, STEPS, Window, blended, intervals_of, middle_of, seen_share,
    shining,
};
pub use library::{IntervalFolder, IntervalLibrary};
pub use maps::{
    BakeStatistics, BakedSurface, Corner, IntervalMaps, MAX_BYTES, MAX_LAYERS, MAX_SIZE, Page, Pair,
};
pub use maps_check::MapsFault;
#[cfg(any(feature = "render", feature = "reference"))]
pub use maps_error::MapsError;
pub use matching::{IntervalScene, MatchedSurface};
pub use scenes::{IntervalLight, IntervalScenes};
pub use surface::surface_hash;
