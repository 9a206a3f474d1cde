//! Orthographic views: all techniques, against the ray caster.

mod eye;
mod maps;
mod models;
mod precision;
mod scenes;
mod wedges;
