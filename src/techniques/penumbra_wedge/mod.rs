//! Soft shadows by penumbra wedges.
//!
//! ```text
//! silhouette edges ──► wedges (parts, shell, records, topology) ──► visibility buffer ──► mask
//!   a part of a light     one record per edge, flat arrays            recorder, passes      resolve
//! ```
//!
//! Take a surface point `p` and one part of a light. Let `w` be the count of the hard shadow from the part's
//! centre at `p`. For every silhouette edge, let `c` be the share of the light that lies behind the edge as
//! seen from the centre: the sector that the projected edge cuts off. The visibility of the part from `p` is
//!
//! `visibility = 1 − w + Σ inner half c − Σ outer half c`.
//!
//! This is exact for the silhouette that `p` sees, whatever the order of its edges. A triangle faces all
//! points of the light alike unless its plane cuts the light. For an edge of a triangle whose plane does, the
//! shader decides whether it is a silhouette edge from `p` ([`WedgeSilhouette::Receiver`]), and its wedge is
//! a sliver.
//!
//! Outside of the edge's wedge `c` is 0, so wedges only need to enclose the penumbra, not to fit it. The
//! terms are blended: `w` by the faces of the hard shadow behind the surface, `c` by the back faces of shells
//! behind it. Where a ray from the surface crosses the separator, both are blended at once as `2 c − 1`,
//! which is 0 at the separator itself. So no pixel depends on the side of the separator on which rounding
//! puts it. A caster that certainly shadows no part of the viewport is counted by the faces in front of the
//! surface instead, with front faces of shells for back faces and without caps.
//!
//! Only the part of the light above the receiver's horizon counts, as in the light pass. Otherwise a convex
//! caster would darken itself under the silhouette from the centre.
//!
//! The sum counts every overlap again. Therefore the same faces, with the same
//! signs, also count how often each of 9 or 21 places on the light is hidden. An edge adds 1 where it hides a
//! place, 0 where it does not, and an intermediate step where it passes close. From both, the resolve
//! estimates how much is hidden at all ([`Overlap::Sampled`]).
//!
//! A surface that reaches into the light has no edges that could be counted. Polygons stand for it (`geometry/cut_patches.rs`):
//! one for a flat surface, however many triangles it has, and 128 as a rule and 256 at most for what one caster has of curved
//! ones, which are drawn more coarsely where that is not enough. Each polygon is clipped to what is before the light and
//! counted by itself, at every pixel (`geometry/cut.rs`). Surfaces in a plane through the light's centre that lie beyond its
//! extent are counted by their edges, like any other, but have no hard shadow.
//!
//! A polygon takes 0.3 µs for each pixel that the light reaches, on a software driver with two cores. So a flat ceiling
//! costs about a hundredth of what a bulb of many triangles does. When the light or the caster moves, finding the polygons
//! takes up to 10 µs of the CPU for each triangle that cuts.
//!
//! # Error and cost
//!
//! The RMSE of the visibility over the penumbra is 0.002 to 0.003 for a box or a ball, coarse or fine, under a square, wide or
//! round light. The table is of 37 models and scenes under a light of 0.5 m at 4 m: the RMSE over the penumbra, and the share
//! of the time of a frame with 64 accumulated hard shadows (medians, on a software driver). It was measured with nine
//! places on the light. There are 21 now, and a second target holds their sums. With them, the whole light's mean is 0.010, its
//! worst is 0.024 and its time is 0.16, on 40 models and without the compiler's optimizations; split lights have not been
//! measured again.
//!
//! | way | mean RMSE | worst RMSE | time |
//! | --- | --- | --- | --- |
//! | wedges, whole light | 0.017 | 0.046 | 0.08 |
//! | wedges, split 2×1 | 0.011 | 0.027 | 0.10 |
//! | wedges, split 2×2 | 0.007 | 0.016 | 0.16 |
//! | wedges, split 3×3 | 0.004 | 0.015 | |
//! | 64 accumulated hard shadows | 0.018 | 0.032 | 1 |
//!
//! For `bonsai`, `flight_helmet`, `grass-small`, `knight`, `low_poly_tree` and `many_cubes`, a smaller error than that of the 64
//! takes 0.26 to 1.0 of their time. `cargo run --example gallery --features reference -- --soft-table --models FOLDER` prints
//! this. Making one wedge takes 0.6 to 0.9 µs of the CPU.
//!
//! | setting | time against the default |
//! | --- | --- |
//! | `silhouette: center` | 0.5 to 1.0 |
//! | `bounds: sphere` | 1.0 to 1.8, and 1.3 to 2.9 times the pixels |
//! | `culling: stencil` (section 4.4 of the paper) | 1.1 to 2.5 |
//! | `culling: none` and `bounds: sphere`, a plain renderer | 1.3 to 2.3 |
//! | `buffer: half` | 0.9 to 1.1 |
//! | `maths: tables` | 1.0 to 1.2 |
//!
//! The gallery prints this table with `--soft-cost`.
//!
//! Source: Assarsson, Dougherty, Mounier & Akenine-Möller 2003, "An Optimized Soft Shadow Volume Algorithm
//! with Real-Time Performance". In substance, the formula with `w` and sectors and equation 1
//! ([`Overlap::Paper`]) are theirs. It is ours that faces alone, without marking, give the same sum; so are
//! the horizon and the places.
//!
//! Source: Laine, Aila, Assarsson, Lehtinen & Akenine-Möller 2005, "Soft Shadow Volumes for Ray Tracing", for
//! the edges that are silhouette edges from some point of the light, for the choice of those that are from
//! `p`, and for counting the hidden samples of a light from signed edges. They do this for each ray and with
//! points; slivers and soft places are ours.

mod assemble;
pub(crate) mod build_wedges;
mod chunks;
pub(crate) mod component;
mod debug_lines;
pub(crate) mod geometry;
#[cfg(feature = "render")]
pub(crate) mod gpu;
pub(crate) mod light_parts;
mod overflow;
mod part_patches;
mod seen_caster;
pub(crate) mod tables;
pub(crate) mod technique;
pub(crate) mod wedges;

pub use component::{
    CoverageMaths, MOST_STACKED, Overlap, PenumbraWedge, VisibilityBuffer, WedgeBounds, WedgeCulling,
    WedgeSilhouette,
};
pub use overflow::{ReducedSums, SPLIT_CAPACITY, WedgeOverflow};
pub use tables::texture::{EmitterTexture, LightTexture, LightTextureError};
pub use wedges::PenumbraWedges;
