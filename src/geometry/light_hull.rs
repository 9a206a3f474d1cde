//! Convex hull of light and view frustum.

/// Convex hull of light and view frustum.
#[derive(Clone, Debug, PartialEq)]
pub struct LightHull {}
