//! Parts that several techniques share: changes that make pictures old, extrusion, near caps, the reach of finite volumes,
//! contours on the GPU, debug lines, texels for debug views, and the memory for textures.

pub(crate) mod exchanged;
pub(crate) mod extrude;
pub(crate) mod finite_reach;
#[cfg(feature = "render")]
pub(crate) mod gpu;
pub(crate) mod inside_test;
pub(crate) mod near_caps;
pub(crate) mod pictures;
pub(crate) mod shadow_lines;
pub(crate) mod texture_memory;
