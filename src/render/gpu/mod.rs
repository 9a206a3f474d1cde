//! Tools on top of wgpu that know nothing of scenes and frames: buffers that grow, ranges, slots, bind groups,
//! timings, read-back.

pub(crate) mod bind_groups;
pub(crate) mod buffers;
pub(crate) mod kept;
pub(crate) mod mipmaps;
pub(crate) mod pipeline_cache;
pub mod readback;
pub(crate) mod runs;
pub(crate) mod slots;
pub(crate) mod stencil_only;
pub(crate) mod strided;
pub(crate) mod timings;
