//! The dense index of objects in spatial order: flags, boxes, and boxes around boxes.

pub(crate) mod box_tests;
pub mod boxes;
pub(crate) mod clusters;
pub(crate) mod collect_objects;
pub(crate) mod lit_bounds;
pub(crate) mod objects;
mod spatial_order;
mod word_bounds;
