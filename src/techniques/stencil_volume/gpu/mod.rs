//! The recorder of stencil volumes.

pub(crate) mod gpu_types;
mod long_lived;
pub(crate) mod pipelines;
mod quads;
pub(crate) mod recorder;
mod rounds;
