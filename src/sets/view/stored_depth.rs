//! How the depth of a view is stored.

/// Reversed depth: 1 on the near plane, 0 at the far end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewDepth {
    /// `near / depth`: of a perspective view.
    Infinite {
        /// View depth of the near plane, > 0.
        near: f64,
    },
    /// Linear between the two: of an orthographic view.
    Finite {
        /// View depth that is stored as 1.
        near: f64,
        /// View depth that is stored as 0; greater.
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

    /// What is stored for a view depth.
    pub fn stored(self, depth: f64) -> f64 {
        match self {
            Self::Infinite { near } => near / depth,
            Self::Finite { near, far } => (far - depth) / (far - near),
        }
    }

    /// By how much stored depth may err, of a surface at a view depth, if `f32` errs by this share.
    pub fn stored_slack(self, depth: f64, share: f64) -> f64 {
        match self {
            Self::Infinite { near } => near / depth * share,
            Self::Finite { .. } => share, // of 1, from which the depths are subtracted
        }
    }

    /// The same of a view depth.
    pub fn slack(self, depth: f64, share: f64) -> f64 {
        match self {
            Self::Infinite { .. } => depth.abs() * share,
            Self::Finite { near, far } if depth.is_finite() => (near.abs() + far.abs()) * share,
            Self::Finite { .. } => 0.0,
        }
    }
}
