//! Occlusion textures: soft shadows of large lights from filtered pictures of the casters, at a cost that does not depend
//! on the size of the light.
//!
//! ```text
//! casters ──► slices parallel to the light ──► filter ──► a lookup for each slice between pixel and light ──► combination
//!             one drawing, a slice a channel    means over rectangles       kernel: the light as seen through the pixel
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `component` | [`OcclusionTexture`], which a user sets on a light |
//! | `technique` | how the component joins the frame |
//! | `build` | the lights with occlusion textures, and their memory |
//! | `light_slices` | the pictures of one light, and whether they changed |
//! | `casters` | the scene that a light reaches, and its casters |
//! | `sliced_light` | the part of a light that its pictures depend on |
//! | `scene_box` | where an object stands |
//! | `shadowless`, `shell` | casters that shadow nothing, such as a flat ground or a sky dome |
//! | `fit`, `axis`, `framing` | number, direction and size of the pictures |
//! | `coarse` | whether the pictures are too coarse for most casters |
//! | `face` | one picture: its projection and its slices |
//! | `records` | records of pictures and lights, for the GPU |
//! | `kernel`, `filter` | what a receiver looks up; twins of the shaders |
//! | `debug_lines` | the slices as lines |
//! | `gpu` | the recorder (feature `render`) |
//!
//! **Lights.** A rectangle has one picture, drawn from behind it. A sphere has one picture towards its casters if they lie to
//! one side of it and not all over that side, else six, which take six times the memory; its kernel is a square as large as its
//! disc, and slices do not match where two of the six pictures meet. A directional light has one picture along its rays;
//! [`OcclusionTexture::angle_deg`] makes it soft. A light without a size casts hard shadows, as wide as a texel. The picture that
//! a light may show is not considered: shadows are those of its mean colour.
//!
//! **Slices.** Slices are cut evenly, or by [`OcclusionTexture::weight`], between the nearest and the farthest point of the
//! casters that the light reaches. A flat ground beyond which nothing is lit takes no slice.
//!
//! **Depths and overlaps.** Beyond the paper, pictures hold the depth of the nearest caster in each slice. Two more sets of
//! pictures are made from them: what each slice covers, and what each slice and all slices before it cover together. A pixel
//! looks up the mean depth of a slice's casters around its kernel, and takes them to be there. Their shadow fades in with the
//! distance behind those that the kernel shows, from 0.15 to 0.75 thicknesses of the slice, also within one slice; closer to
//! their caster shadows are lost, and more slices bring them closer. The last set tells how much of a slice lies behind casters
//! of the slices before it; see [`SliceCombination::Overlap`].
//!
//! The paper's combinations know neither. With them, the slice that holds a receiver does not shadow it, and the slice before
//! it fades in over a whole thickness. Casters cast from the far end of their slice for receivers just behind it, and from its
//! middle once it has faded in, which halves the error of the paper's far end.
//!
//! **The receiver's own plane.** A flat surface hides nothing from itself. A slice treats its casters as lying at one depth,
//! which could put a receiver's own surface in front of it. The kernel is therefore clipped to the part clear of that surface.
//! The shadow of another caster there shifts by the same amount: the errors of boxes over each other are a quarter larger for it. Kernels in the
//! receiver's own slice are not cut, since depths tell its surface from others there, unless `close_leaks` fills slices.
//!
//! **Pictures.** A picture shows the casters and their surroundings, as far as a kernel may reach that touches them. Receivers
//! may lie outside of it. Casters are measured along their own axes as well as those of the world, so a turned scene has
//! slices as thin as a straight one.
//!
//! **Memory and cost.** With N-buffers, 19 bytes for each texel and four slices, and 89 for overlaps; see [`SliceFilter`].
//! A light of 8 slices of 256² texels takes 11.7 MB, and 2.5 MB by the product. With 1024² texels overlaps take 187 MB of the
//! 256 MB that all techniques share by default. Pictures are kept while nothing changes. Drawing is one pass over the casters for
//! up to 16 slices. A pixel costs two lookups for each slice between itself and the light by the paper's combinations, and up to
//! twelve for each slice with casters around the kernel by the overlap, whatever the size of the light.
//!
//! **N-buffers.** The paper keeps the mean over the square at every texel, for all sizes of squares. Here squares above level 3
//! begin an eighth of their side apart, each level has a quarter as many values as the level below, and lookups interpolate. That
//! takes 11 samples for each texel at most, where 1024² values in each of ten levels take 37. Summed areas take 64 loads of 16
//! bytes. On a software driver they take 8 times as long to build by the product, and 5 times by overlaps: `cargo test
//! --all-features --test gpu occlusion_texture::cost::building -- --ignored --nocapture` prints both times. Levels that no kernel
//! reaches are not built. Coverage has 8 bits up to level 3.
//!
//! **Closed casters.** Beyond the paper, its combinations draw casters whose mesh is closed with their fronts alone, as seen from
//! the light. Front and back of a box would otherwise hide the same rays in two slices, and count twice. Measured overlaps know
//! that they hide the same rays, and draw both sides. They also fill the slices between front and back: one more drawing counts the
//! surfaces of closed casters before the top of each slice, and where fronts and backs differ the top lies inside of a caster.
//! Otherwise light would pass deep casters beside the light's axis, whose steep sides are thin strips in each slice, which kernels
//! pass beside. Casters within one slice, and those that are not wholly before the light, are not filled. Backs do not fill the
//! next slice for [`OcclusionTexture::close_leaks`], because nothing is behind them.
//!
//! **Limits.** A caster that cuts the light, or touches it, lies within a slice that begins at the light, and its shadow is rough.
//! Light leaks through thin walls that stand within 30° of the light's axis and are not closed meshes, where a slice is much
//! thicker than the wall: kernels pass beside the wall's strip in the slice. More slices and [`OcclusionTexture::close_leaks`] mend
//! most of that. All casters that the light reaches share one picture, so lights without a range spend their texels and slices on all
//! casters of the scene. If most casters are lost because of this, a report says so. A ground, and a convex shell around
//! everything lit, such as a sky dome or a room in one mesh, are ignored, both as casters and when slices are sized. Casters
//! that are a hundred times as far from a rectangle or sphere as most others are ignored when slices are sized, and may cast
//! nothing.
//!
//! **Errors.** Root mean square errors of visibility under a square light of 1 m, 3 m above a ground, with 8 slices of 256²
//! texels; without a shadow the errors are 0.15 to 0.35. `cargo test --all-features --test gpu
//! occlusion_texture::truth::errors_by_hand -- --ignored --nocapture` prints them for 4, 8 and 16 slices and all filters.
//!
//! | scene | overlap | product | maximum | sum | overlap, leaks closed | product, leaks closed |
//! | --- | --- | --- | --- | --- | --- | --- |
//! | a plate | 0.012 | 0.012 | 0.012 | 0.012 | 0.012 | 0.056 |
//! | boxes over each other | 0.031 | 0.036 | 0.061 | 0.044 | 0.037 | 0.111 |
//! | a tree of 160 leaves | 0.170 | 0.172 | 0.228 | 0.204 | 0.172 | 0.214 |
//! | two slanted wings | 0.019 | 0.092 | 0.196 | 0.018 | 0.017 | 0.056 |
//! | balls over hills | 0.014 | 0.027 | 0.033 | 0.022 | 0.014 | 0.049 |
//!
//! The sum is the best of the paper's combinations where one surface passes through the slices, the product where many objects
//! overlap, and the maximum nowhere. Measured overlaps are as good as the best of them everywhere. Summed areas take 0.008 off
//! the errors of a plate, and mipmaps add up to 0.010.
//!
//! Under a plate that rises 5 cm a frame from slice to slice, visibility changes by at most 0.08 more in a frame than it should,
//! with 8 slices and with 16. With the product it is 0.13 and 0.11, since the plate's shadow moves by the thickness of a slice
//! at once, and the plate begins or ceases to count as independent of the casters in the same slice.
//!
//! Source: Eisemann & Décoret 2008, "Occlusion Textures for Plausible Soft Shadows". The paper packs slices and levels into
//! a few textures, because its hardware could not index textures; here they are layers of an array.

mod axis;
pub(crate) mod build;
pub(crate) mod casters;
pub(crate) mod coarse;
pub(crate) mod component;
mod debug_lines;
pub(crate) mod face;
pub(crate) mod filter;
pub(crate) mod fit;
pub(crate) mod framing;
#[cfg(feature = "render")]
pub(crate) mod gpu;
pub(crate) mod kernel;
pub(crate) mod light_slices;
pub(crate) mod records;
pub(crate) mod scene_box;
pub(crate) mod shadowless;
pub(crate) mod shell;
pub(crate) mod sliced_light;
pub(crate) mod technique;

pub use build::OcclusionTextures;
pub use component::{MOST_SLICES, OcclusionTexture, SliceCombination, SliceFilter};
