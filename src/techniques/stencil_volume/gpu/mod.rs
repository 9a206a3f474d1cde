//! The recorder of stencil volumes.

pub(crate) mod gpu_types;
pub(crate) mod pipelines;
mod quads;
pub(crate) mod recorder;
mod rounds;
