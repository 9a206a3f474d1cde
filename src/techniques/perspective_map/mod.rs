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
//! | `parts` | boxes around the visible receivers and the parts of large ones |
//! | `receivers` | the points that the light's camera must see: bounds of receivers cut by the frustum |
//! | `shadowed` | where casters can darken anything at all |
//! | `projection` | the viewer's projection, slid back; the light and the receivers in its space |
//! | `smallest_cone` | the smallest cone around directions |
//! | `light_camera` | one face: a camera at the light with the smallest cone's axis |
//! | `cube` | several faces: sides of the unit cube as the light sees them |
//! | `texels` | texels per pixel of the screen, at sample points |
//! | `fit_input` | the casters and the points that a light's faces are fitted to |
//! | `fit` | the faces of a light in this frame |
//! | `reports` | what a user is told |
//! | `place_face` | a picture as a face: its frame at the light, its homography, the depths of casters |
//! | `grounds` | receivers whose shadows are blurred ([`BlurredGround`](crate::scene::BlurredGround)) |
//! | `gpu` | the recorder (feature `render`) |
//!
//! **What a matrix may do.** Every matrix whose centre is the light gives the same shadows, because a ray of
//! light falls on one texel. Matrices differ by a homography of the picture, that is, by where the texels are.
//! The faces are therefore kept as a frame at the light and a homography, both in `f64`, and their depth is
//! the distance from the light, as in plain maps. This is the inverse projection of the source: w has one sign
//! along the whole ray, also where the ray passes behind the viewer, so casters there are drawn in their order.
//!
//! **Depth.** A directional light's depth is the distance above a plane under the receivers. Corners of large
//! casters have a w hundreds of times that of receivers near the eye, and the rounding error of w is proportional to depth.
//! Depth is therefore measured so that it is small at the receivers, and the comparison allows for the error that remains.
//!
//! **Quality.** No homography serves all views. With the light's direction across the view it is near the
//! ideal; with the light ahead or behind, a near object and a far one share the middle of the picture: w cannot
//! change along the light, so no matrix tells them apart, and the gain over a uniform map shrinks. Where it shrinks to less than
//! 1 / 0.6, or where texels stay much larger than pixels because the world reaches over kilometres, the faces of a cube with half
//! the side take over if their texels are less than half as long: they do tell near and far apart. Texels that are large even
//! so are reported. A light at a position gets the cube's faces if one picture has texels longer than two pixels, and twice as long as
//! the faces have: a picture that is nearly 180° wide has hardly any texels in its middle. The slide is chosen by
//! measuring the longer sides of texels on the screen, because long thin texels make edges coarse; a measure of their area
//! doubled the error in a town. On `town_A`, `dungeon_A` and a plain of 4 km the nearest tenth of the pixels has 1.9 to 225
//! times the texels of four cascades of the same total, and at least 4 times those of a uniform map at every angle of the
//! light; the error is at most that of the cascades at all 37 angles (`tests/gpu/perspective_map/quality.rs`, the ignored
//! test).
//!
//! In 15 views of each of 39 models, 7 of 927,281 pixels are wrong: those farther than a texel of 1024² from an edge are
//! judged. The worst view has 0.17 % (`tests/gpu/perspective_map/models.rs`, with all models).
//!
//! **What is shown.** The light's camera sees the bounds of visible receivers, part by part where they are large, cut by
//! the view, by a spot light's cone and, for a directional light, by the box around all shadows. What no face shows is
//! lit. From 256 receivers on, neighbours are joined into boxes that are small as seen from the eye.
//!
//! **Comparison.** Each texel is compared with the depth of the receiver's plane in that texel, in the shader. Hardware
//! compares four texels with one depth; close to the eye w changes from texel to texel by more than it does from a
//! caster to a receiver a hundredth of its distance below, and light leaked through.
//!
//! **Blurred grounds.** Receivers with a [`BlurredGround`](crate::scene::BlurredGround) show a Gaussian of their
//! visibility. The casters of a face are drawn again in colours, 1 in the channel of a ground and 0 elsewhere, where
//! their depth is that of the map. The picture is blurred along two directions in the plane of the ground, with taps at
//! equal distances in metres, and looked up by all receivers of that ground. A ground that casts nothing hides the
//! casters below it all the same. What is under an object that stands on the ground counts as dark.
//!
//! **Rounding.** Corners of casters round by a share of their w, and where w is small that is a larger share of depth. So w grows
//! by 256 times at most from the nearest receiver to the farthest, by 1024 times where texels would otherwise be huge, and by
//! 8192 times to the corners of a flat ground, whose triangles pass close by the eye. Over hills of 4 km and under a sun close
//! above the horizon ahead, this leaves 0.7 % of the pixels wrong in a picture of 240 × 135; four cascades leave 0.5 %.
//!
//! **Swim.** The texels follow the view: when the view turns or moves, they fall elsewhere, and edges of
//! shadows change by up to a texel. In a view of a plain of 4 km that turned by a third of a degree a frame,
//! 1.5 % of the pixels changed wrongly, and 0.2 % under cascades with as many texels
//! (`tests/gpu/perspective_map/quality.rs`). [`ShadowMap`](super::ShadowMap) has cascades that stand still. Use
//! perspective maps for views that stand still or cut, for large plains, and where edges are filtered or texels
//! are smaller than pixels; use cascades for a view that moves slowly past sharp shadows.
//!
//! Source: Kozlov 2004, "Perspective Shadow Maps: Care and Feeding", GPU Gems ch. 14; Stamminger & Drettakis
//! 2002, "Perspective Shadow Maps".

pub(crate) mod component;
pub(crate) mod cube;
pub(crate) mod fit;
pub(crate) mod fit_input;
#[cfg(feature = "render")]
pub(crate) mod gpu;
pub(crate) mod grounds;
pub(crate) mod light_camera;
pub(crate) mod parts;
pub(crate) mod place_face;
pub(crate) mod projection;
pub(crate) mod receivers;
pub(crate) mod reports;
pub(crate) mod shadowed;
pub(crate) mod smallest_cone;
pub(crate) mod technique;
pub(crate) mod texels;
pub(crate) mod view_space;

pub use component::{MapFocus, PerspectiveFaces, PerspectiveMap, PerspectiveProjection};
pub use fit::Fit;
pub use technique::PerspectiveMaps;
