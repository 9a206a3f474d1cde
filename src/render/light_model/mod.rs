//! The GPU side of the light model ([`scene::light_model`](crate::scene::LightModel)).
//!
//! One pass for each light multiplies its mask by the factors of its shape and distances, in frames of our own, of
//! a host and of Bevy ([`function`]). Blended surfaces have no mask of their own behind the
//! nearest one, so the light pass evaluates the same factor for them.
//!
//! Cookies and profiles are multiplied into the same mask by a pass of their own (`textures`), which only lights that
//! have one pay for.
//!
//! The light function may look the shape up in a texture (`barn_maps`), which a light asks for with a
//! [`BarnMap`](crate::scene::BarnMap).
//!
//! The source bakes the shape into textures: a barn map, and a map of the distances. On lavapipe, beside other work on
//! both cores, a barn map with the formula of the distances took 0.44 to 0.62 of the time of the formulas, and both maps
//! 0.60 to 0.70 (`tests/gpu/barn_map.rs` prints nanoseconds a pixel; three runs). So there is
//! no map of distances. The barn map is a setting, because a texel of a map cannot hold an edge that is sharper than itself.
//!
//! A frame of 640×360 with stencil volumes took, as a ratio to the same lights without a model, on lavapipe beside other
//! work (`tests/gpu/light_model/cost.rs` prints it; one run):
//!
//! | part | 1 light | 9 lights |
//! | --- | --- | --- |
//! | shape, or distances | 1.45 | 1.63 |
//! | shape with a barn map | 1.41 | 1.56 |
//! | colour of shadows | 1.24 | 1.56 |
//! | cookie | 1.61 | 2.02 |
//! | profile | 1.45 | 1.66 |
//! | cookie, profile, shape, distances and colour of shadows | 2.04 | 2.53 |
//!
//! Most of it is the mask, which a light with stencil volumes has not without a model.

pub(crate) mod barn_maps;
pub(crate) mod constants;
pub(crate) mod function;
pub(crate) mod textures;
