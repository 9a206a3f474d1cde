//! Scene data on the GPU: meshes, materials, textures, the table of objects, and the constants of lights.

pub mod gpu_types;
pub(crate) mod light_constants;
pub(crate) mod materials;
pub(crate) mod meshes;
pub(crate) mod object_rows;
pub(crate) mod objects;
pub(crate) mod textures;
