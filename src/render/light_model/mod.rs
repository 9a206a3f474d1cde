//! The GPU side of the light model ([`scene::light_model`](crate::scene::LightModel)).
//!
//! What is a factor of the light (shape, distances) is multiplied into its mask by one pass for each light, in
//! frames of our own, of a host and of Bevy ([`function`]). Blended surfaces have no mask of their own behind the
//! nearest one, so the light pass evaluates the same factor for them.

pub(crate) mod constants;
pub(crate) mod function;
