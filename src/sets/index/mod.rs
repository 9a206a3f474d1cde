//! The dense index of objects: flags, boxes, clusters of boxes, in spatial order.

pub(crate) mod box_tests;
pub mod boxes;
pub(crate) mod clusters;
pub(crate) mod collect_objects;
pub(crate) mod lit_bounds;
pub(crate) mod objects;
mod spatial_order;
mod word_bounds;
