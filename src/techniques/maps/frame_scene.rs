//! The part of a frame that maps look at.

use crate::sets::{Objects, ViewData};

/// The frame's data from which faces are made, besides the light.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// All objects.
    pub objects: &'a Objects,
    /// The view of the frame.
    pub view: &'a ViewData,
    /// Generation of the view.
    pub view_generation: u64,
    /// Default near plane as a share of the reach. Depth is floating point and reversed, so a near plane close to the
    /// light costs no precision.
    pub near_share: f64,
}
