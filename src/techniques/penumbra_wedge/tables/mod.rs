//! Tables that coverage is looked up in: of angles, of sectors, of textured lights.

#[cfg(feature = "render")]
pub(crate) mod lookup;
#[cfg(feature = "render")]
pub(crate) mod table_buffer;
pub(crate) mod texture;
