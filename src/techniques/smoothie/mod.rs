//! Smoothies: a shadow map whose shadows are softened by rims drawn along the casters' silhouettes.
//!
//! ```text
//! silhouettes of casters ──► edges and corners ──► smoothie buffer ──┐
//!   (object space)            records, world axes    least alpha     ├─► visibility
//! casters ─────────────────────────────────────────► depth map ──────┘
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `component` | [`Smoothie`], which a user sets on a light |
//! | `technique` | how the component joins the frame |
//! | `outline` | smoothie edges of a caster, from its silhouette |
//! | `records` | records of edges and faces, for the GPU |
//! | `expand` | vertices of edges and corners; twin of the vertex stage |
//! | `shade` | what a texel holds and how it is read; twin of the shader |
//! | `gpu` | the recorder (feature `render`) |
//!
//! Faces, cascades, casters' depth, bias, cache and memory are those of [`maps`](super::maps).
//!
//! **What a pixel gets.** Behind a caster 0; behind a smoothie `α′ = α / (1 − b/r)`, at most 1; elsewhere 1. Here `α`
//! grows from 0 at the silhouette to 1 at the smoothie's rim, and `b` and `r` are the distances of smoothie and
//! receiver from the light. For a directional light, whose distance is infinite, `1 − b/r` stands for the drop between
//! the two, as a share of the drop at which the penumbra is as wide as the smoothie.
//!
//! **Width.** A smoothie of `w` metres at distance `b` makes a penumbra of `w (r − b) / b` metres on a receiver that
//! faces the light. The outer half of the penumbra of a sphere light of radius `w` is this wide.
//!
//! **Lights.** Spot lights have one face, wide ones and all other lights at a position six, and directional lights the
//! cascades of maps: a single fitted box would spend its texels on the distance, and smoothies have the same width in
//! metres in every cascade. Spheres and rectangles cast from their centre, and their size gives the width.
//!
//! **Cost.** Beside a bilinear map: a second texture of 4 bytes a texel, one instance of 24 vertices per silhouette
//! edge of each face that is drawn again, and four texels instead of one comparison in the lookup. Casters that stand
//! still are drawn once.
//!
//! **Limits.** The penumbra lies outside the umbra alone, so a shadow is darker than that of the area light, and a
//! small caster far from its receiver keeps its umbra. A receiver that casts nothing, or a moving caster, may be too
//! dark where it is behind one smoothie and in front of another. Casters with holes in their texture get no smoothies.
//! The penumbra of a directional light does not widen beyond its smoothie.
//!
//! Source: Chan & Durand 2003, "Rendering Fake Soft Shadows with Smoothies".

pub(crate) mod component;
pub(crate) mod expand;
#[cfg(feature = "render")]
pub(crate) mod gpu;
pub(crate) mod outline;
pub(crate) mod records;
pub(crate) mod shade;
pub(crate) mod technique;

pub use component::{Smoothie, SmoothieWidth};
