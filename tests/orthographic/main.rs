//! Orthographic views: all techniques, against the ray caster.

#[path = "../harness/mod.rs"]
mod harness;

mod maps;
mod models;
mod precision;
mod scenes;
mod wedges;
