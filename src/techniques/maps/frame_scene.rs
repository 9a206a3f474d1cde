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

/// Returns the side of a pixel, metres: at view depth 1, or at any depth of an orthographic view.
pub fn pixel_metres(view: &ViewData) -> f64 {
    let shape = view.frustum.shape();
    2.0 * shape.half_up * shape.up.length() / f64::from(view.viewport.y)
}
