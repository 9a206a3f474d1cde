//! View frustum with its far plane at infinity.

/// The view frustum.
#[derive(Clone, Debug, PartialEq)]
pub struct Frustum {}
