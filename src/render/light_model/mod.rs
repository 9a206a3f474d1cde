//! The GPU side of the light model ([`scene::light_model`](crate::scene::LightModel)).
//!
//! What is a factor of the light (shape, distances) is multiplied into its mask by one pass for each light, in
//! frames of our own, of a host and of Bevy ([`function`]). Blended surfaces have no mask of their own behind the
//! nearest one, so the light pass evaluates the same factor for them.
//!
//! Cookies and profiles are multiplied into the same mask by a pass of their own (`textures`), which only lights that
//! have one pay for.
//!
//! The paper bakes the shape into textures: a barn map, and a map of the distances. Measured on lavapipe
//! (`tests/gpu/barn_map.rs`; nanoseconds a pixel, without the rest of the pass): the formulas take 70 to 82, a barn map
//! with the formula of the distances 35 to 41, both maps 40 to 55. So a barn map halves the arithmetic there, and a map of
//! the distances gains nothing. The formulas stay, because a map cannot hold sharp edges, and errs by more than a five
//! hundredth where the light fades out.

pub(crate) mod constants;
pub(crate) mod function;
pub(crate) mod textures;
