//! Tables from which coverage is looked up: angles, sectors, and textured lights.

#[cfg(feature = "render")]
pub(crate) mod lookup;
#[cfg(feature = "render")]
pub(crate) mod table_buffer;
pub(crate) mod texture;
