//! The import of glTF files.

mod faults;
mod gltf_builder;
mod gltf_import;
mod gltf_robustness;
mod gltf_visibility;
mod in_the_world;
