//! How the depth of a view is stored.

/// The mapping from view depth to stored depth. Stored depth is reversed: 1 on the near plane, 0 at the far
/// end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewDepth {
    /// Stored depth is `near / depth`. Perspective views use this.
    Infinite {
        /// View depth of the near plane, greater than 0.
        near: f64,
    },
    /// Stored depth is linear between `near` and `far`. Orthographic views use this.
    Finite {
        /// View depth that is stored as 1.
        near: f64,
        /// View depth that is stored as 0; greater than `near`.
        far: f64,
    },
}

impl ViewDepth {
    /// View depth of the near plane.
    pub fn near(self) -> f64 {
        match self {
            Self::Infinite { near } | Self::Finite { near, .. } => near,
        }
    }

    /// The value that is stored for a view depth.
    pub fn stored(self, depth: f64) -> f64 {
        match self {
            Self::Infinite { near } => near / depth,
            Self::Finite { near, far } => (far - depth) / (far - near),
        }
    }

    /// Error of the stored depth of a surface at `depth`, if `f32` arithmetic has a relative error of
    /// `share`.
    pub fn stored_slack(self, depth: f64, share: f64) -> f64 {
        match self {
            Self::Infinite { near } => near / depth * share,
            Self::Finite { .. } => share, // relative to 1, from which the depths are subtracted
        }
    }

    /// Error of the view depth of a surface at `depth`, if `f32` arithmetic has a relative error of `share`.
    pub fn slack(self, depth: f64, share: f64) -> f64 {
        match self {
            Self::Infinite { .. } => depth.abs() * share,
            Self::Finite { near, far } if depth.is_finite() => (near.abs() + far.abs()) * share,
            Self::Finite { .. } => 0.0,
        }
    }
}
