//! The recorder of penumbra wedges.

pub(crate) mod buffers;
mod form;
mod passes;
pub(crate) mod pipelines;
mod plans;
pub(crate) mod recorder;
mod upload;
mod windows;
