//! Occlusion textures: soft shadows of large lights from filtered pictures of the casters, at a cost that does not depend
//! on the size of the light.
//!
//! ```text
//! casters ──► slices parallel to the light ──► filter ──► a lookup for each slice between pixel and light ──► product
//!             one drawing, a slice a channel    means over rectangles       kernel: the light as seen through the pixel
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `component` | [`OcclusionTexture`], which a user sets on a light |
//! | `technique` | how the component joins the frame |
//! | `build` | the lights with occlusion textures, and their memory |
//! | `light_slices` | the pictures of one light, and whether they changed |
//! | `fit` | number, direction and size of the pictures |
//! | `face` | one picture: its projection and its slices |
//! | `records` | records of pictures and lights, for the GPU |
//! | `kernel`, `filter` | what a receiver looks up; twins of the shaders |
//! | `debug_lines` | the slices as lines |
//! | `gpu` | the recorder (feature `render`) |
//!
//! **Lights.** A rectangle has one picture, drawn from behind it. A sphere has one picture if all casters lie to one side
//! of it, else six; its kernel is a square as large as its disc, and slices do not match where two of the six pictures
//! meet. A directional light has one picture along its rays; [`OcclusionTexture::angle_deg`] makes it soft. A light without
//! a size casts hard shadows, as wide as a texel. The picture that a light may show is not considered: shadows are those of
//! its mean colour.
//!
//! **Slices.** Slices are cut evenly, or by [`OcclusionTexture::weight`], between the nearest and the farthest point of the
//! casters that the light reaches. A flat ground beyond which nothing is lit takes no slice. The slice that holds a receiver
//! does not shadow it, and the slice before it fades in with the distance, so nothing jumps where geometry passes from
//! slice to slice. Objects therefore lose the contact shadow
//! within about one slice, and gain it with more slices. The source lets casters cast from the far end of their slice; here
//! they do so for receivers just behind it, and cast from its middle once the slice has faded in, which halves what the
//! projection onto one plane adds to their size.
//!
//! **Memory and cost.** With N-buffers, 8 bytes for each texel, level and four slices; see [`SliceFilter`]. Pictures are
//! kept while nothing changes. Drawing is one pass over the casters for up to 16 slices; a pixel costs two lookups for each
//! slice between itself and the light, whatever the size of the light.
//!
//! **Closed casters.** Beyond the paper, casters whose mesh is closed are drawn with their fronts alone, as seen from the
//! light. Front and back of a box would otherwise hide the same rays in two slices, and count twice.
//!
//! **Limits.** Occluders in different slices count as independent: a surface that passes through several slices hides
//! disjoint parts of the light, and the product lets some of it through; [`OcclusionTexture::close_leaks`] mends that where
//! it matters. Everything that the light reaches shares one picture, so lights without a range spend
//! their texels on the whole scene.
//!
//! **Errors.** Root mean square errors of visibility under a square light of 1 m, 3 m above a ground, with 8 slices of 256²
//! texels; without a shadow the errors are 0.15 to 0.35. `cargo test --all-features --test gpu
//! occlusion_texture::truth::errors_by_hand -- --ignored --nocapture` prints them for 4, 8 and 16 slices and all filters.
//!
//! | scene | product | maximum | sum | product, leaks closed |
//! | --- | --- | --- | --- | --- |
//! | a plate | 0.012 | 0.012 | 0.012 | 0.058 |
//! | boxes over each other | 0.035 | 0.063 | 0.040 | 0.090 |
//! | a tree of 160 leaves | 0.128 | 0.192 | 0.160 | 0.169 |
//! | two slanted wings | 0.100 | 0.200 | 0.028 | 0.046 |
//! | balls over hills | 0.027 | 0.033 | 0.022 | 0.048 |
//!
//! The sum is the best where one surface passes through the slices, the product where many objects overlap, and the maximum
//! nowhere. Summed areas take 0.008 off the errors of a plate, and mipmaps add up to 0.013.
//!
//! Source: Eisemann & Décoret 2008, "Occlusion Textures for Plausible Soft Shadows". The paper packs slices and levels into
//! a few textures, because its hardware could not index textures; here they are layers of an array.

pub(crate) mod build;
pub(crate) mod component;
mod debug_lines;
pub(crate) mod face;
pub(crate) mod filter;
pub(crate) mod fit;
#[cfg(feature = "render")]
pub(crate) mod gpu;
pub(crate) mod kernel;
pub(crate) mod light_slices;
pub(crate) mod records;
pub(crate) mod technique;

pub use build::OcclusionTextures;
pub use component::{MOST_SLICES, OcclusionTexture, SliceCombination, SliceFilter};
