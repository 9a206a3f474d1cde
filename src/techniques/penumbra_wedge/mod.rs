//! Soft shadows by penumbra wedges.
//!
//! ```text
//! silhouette edges ──► wedges (parts, shell, records, topology) ──► visibility buffer ──► mask
//!   a part of a light     a record an edge, flat arrays              node, pipelines       resolve
//! ```
//!
//! Visibility of a part of a light from a surface point `p` is one less what is covered. With the hard shadow's count
//! `w` at the part's centre and for every silhouette edge the share `c` of the light that lies behind the edge as seen
//! from the centre (the sector that the projected edge cuts off),
//!
//! `visibility = 1 − w + Σ inner half c − Σ outer half c`,
//!
//! exact for the silhouette that `p` sees, whatever the order of its edges. A triangle is on the same side of it from all
//! of the light unless its plane cuts the light; of edges beside such triangles the shader asks whether they are of the
//! silhouette from `p` ([`WedgeSilhouette::Receiver`]), and their wedges are slivers. `c` is 0 outside
//! of the edge's wedge, so wedges need to enclose, not to fit. What is drawn is blended: `w` by the faces of the hard
//! shadow behind the surface, `c` by the back faces of shells behind it, and where a ray from the surface crosses the
//! separator, both at once: `2 c − 1`, which is 0 at the separator itself. So no pixel depends on which side of the
//! separator rounding puts it. Of casters that surely shadow no part of the viewport, faces before the surface are
//! counted instead, fronts of shells for backs, and caps are not needed.
//!
//! Only what of the light is above the receiver's horizon is looked at, as the light pass does; or else, under the
//! silhouette from the centre, a convex caster would darken itself.
//!
//! The sum counts what overlaps as often as it does. The same faces, with the same signs, also count nine places on the
//! light, 1 where an edge hides a place, 0 where not, and by steps between where it passes near: so many times each place
//! is hidden. The resolve tells from both what is hidden at all ([`Overlap::Sampled`]).
//!
//! Source: Assarsson, Dougherty, Mounier & Akenine-Möller 2003, "An Optimized Soft Shadow Volume Algorithm with
//! Real-Time Performance". The formula with `w` and sectors is theirs in substance; that faces alone, without marking,
//! give the same sum is ours, and so are the horizon and the places; theirs is equation 1 ([`Overlap::Paper`]).
//! Edges that are of the silhouette from some point of the light, those of them that are from `p`, and counting the hidden
//! samples of a light from signed edges: Laine, Aila, Assarsson, Lehtinen & Akenine-Möller 2005, "Soft Shadow Volumes for
//! Ray Tracing", there for each ray and with points; slivers, and that places are soft, are ours.

mod assemble;
mod chunks;
pub(crate) mod component;
pub(crate) mod geometry;
#[cfg(feature = "render")]
pub(crate) mod gpu;
pub(crate) mod light_parts;
mod overflow;
pub(crate) mod tables;
pub(crate) mod wedges;

pub use component::{
    CoverageMaths, MOST_STACKED, Overlap, PenumbraWedge, VisibilityBuffer, WedgeBounds, WedgeCulling,
    WedgeSilhouette,
};
pub use overflow::{SPLIT_CAPACITY, WedgeOverflow};
pub use tables::texture::{EmitterTexture, LightTexture, LightTextureError};
pub use wedges::PenumbraWedges;
