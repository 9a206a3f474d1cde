//! Files as exporters write them: against the letter of the specification, with extensions, compressed.

mod clearcoat;
mod compressed;
mod documents;
mod materials;
mod nodes;
mod pictures;
