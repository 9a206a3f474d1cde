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
}
