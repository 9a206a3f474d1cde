//! Faults that outside suites and bug reports found, each with its whole kind.

#[path = "../gltf_builder/mod.rs"]
mod gltf_builder;
#[path = "../harness/mod.rs"]
mod harness;

mod files;
mod light_on_surface;
mod scenes;
mod stacks;
mod transforms;
