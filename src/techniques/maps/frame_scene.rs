//! The part of a frame that maps are built from.

use crate::sets::{Objects, ViewData};

/// The data of the frame, besides the light, from which the faces of a map are made.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// All objects of the frame.
    pub objects: &'a Objects,
    /// The view of the frame.
    pub view: &'a ViewData,
    /// Generation of the view. It changes when the view changes, so that cascades are drawn again.
    pub view_generation: u64,
    /// Default near plane as a share of the reach. Depth is floating point and reversed, so a near plane close to the
    /// light costs no precision.
    pub near_share: f64,
}
