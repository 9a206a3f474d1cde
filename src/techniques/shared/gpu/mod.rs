//! Silhouettes of casters on the GPU.

pub(crate) mod contour_pool;
