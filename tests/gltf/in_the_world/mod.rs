//! Files as exporters write them: against the letter of the specification, with extensions, compressed.

mod clearcoat;
mod compressed;
mod documents;
pub mod materials;
mod nodes;
#[cfg(any(feature = "gltf-draco", feature = "gltf-meshopt"))]
mod other_data;
mod pictures;
mod vertex_alpha;
