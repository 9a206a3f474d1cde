//! Occlusion textures against the ray caster, against their CPU twin, and on input that is bad.

mod bad_input;
mod cast;
mod cost;
mod edges;
mod leaks;
mod motion;
mod properties;
mod scenes;
mod truth;
mod twin;
mod wide;
