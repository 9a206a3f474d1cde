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
}
