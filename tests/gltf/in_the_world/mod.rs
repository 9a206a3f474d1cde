//! Files as exporters write them: against the letter of the specification, with extensions, compressed.

mod clearcoat;
mod compressed;
mod documents;
pub mod materials;
mod nodes;
mod pictures;
mod vertex_alpha;
