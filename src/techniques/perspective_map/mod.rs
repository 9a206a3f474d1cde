//! Perspective shadow maps: maps whose texels are where the screen's pixels are.
//!
//! The casters are drawn as they look from the light after the viewer's perspective projection, in which near
//! objects are large. One picture then serves a room and a landscape alike.
//!
//! ```text
//! bounds of lit receivers ──► points cut by the view ──► best near plane ──► slide ──► light's camera ──► maps
//!      (of the sets)            view coordinates          nearest point     measured    smallest cone      faces with
//!                                                                                       or cube faces      a matrix
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `component` | [`PerspectiveMap`], which a user sets on a light |
//! | `technique` | how the component joins the frame |
//! | `view_space` | coordinates in which the view frustum is simple |
//! | `receivers` | the points that the light's camera must see: bounds of receivers cut by the frustum |
//! | `projection` | the viewer's projection, slid back; the light and the receivers in its space |
//! | `smallest_cone` | the smallest cone around directions |
//! | `light_camera` | one face: a camera at the light with the smallest cone's axis |
//! | `cube` | several faces: sides of the unit cube as the light sees them |
//! | `texels` | texels per pixel of the screen, at sample points |
//! | `fit` | the faces of a light in this frame |
//!
//! **What a matrix may do.** Every matrix whose centre is the light gives the same shadows, because a ray of
//! light falls on one texel. Matrices differ by a homography of the picture, that is, by where the texels are.
//! The faces are therefore kept as a frame at the light and a homography, both in `f64`, and their depth is
//! the distance from the light, as in plain maps. This is the inverse projection of the source: w has one sign
//! along the whole ray, also where the ray passes behind the viewer, so casters there are drawn in their order.
//!
//! **Depth.** A directional light's depth is the distance above a plane under the receivers. Corners of large
//! casters have a w hundreds of times that of receivers near the eye, and its rounding is a share of depth: depth
//! is small where the receivers are, and comparisons allow for the rest.
//!
//! **Quality.** No homography serves all views. With the light's direction across the view it is near the
//! ideal; with the light ahead or behind, a near object and a far one share the middle of the picture, and the
//! gain over a uniform map shrinks. The slide is chosen by measuring, so a map is not poorer than the uniform
//! one by that measure.
//!
//! **Known fault.** Where the near plane touches a surface, on four of 40 models 5 to 13 % of the pixels of the view
//! were lit that should be dark. The cause is not known (`tests/gpu/perspective_map/models.rs`).
//!
//! **Swim.** The texels follow the view: when the view turns or moves, they fall elsewhere, and edges of
//! shadows change by up to a texel. In a view of a plain of 4 km that turned by a third of a degree a frame,
//! 1.4 % of the pixels changed wrongly, and 0.5 % under cascades with as many texels
//! (`tests/gpu/perspective_map/quality.rs`). [`ShadowMap`](super::ShadowMap) has cascades that stand still. Use
//! perspective maps for views that stand still or cut, for large plains, and where edges are filtered or texels
//! are smaller than pixels; use cascades for a view that moves slowly past sharp shadows.
//!
//! Source: Kozlov 2004, "Perspective Shadow Maps: Care and Feeding", GPU Gems ch. 14; Stamminger & Drettakis
//! 2002, "Perspective Shadow Maps".

pub(crate) mod component;
pub(crate) mod cube;
pub(crate) mod fit;
pub(crate) mod light_camera;
pub(crate) mod projection;
pub(crate) mod receivers;
pub(crate) mod smallest_cone;
pub(crate) mod technique;
pub(crate) mod texels;
pub(crate) mod view_space;

pub use component::{MapFocus, PerspectiveFaces, PerspectiveMap, PerspectiveProjection};
pub use fit::Fit;
pub use technique::PerspectiveMaps;
