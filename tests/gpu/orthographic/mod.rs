//! Orthographic views: all techniques, against the ray caster.

mod maps;
mod models;
mod precision;
mod scenes;
mod wedges;
