//! Maps: what they look up is what the ray caster sees, up to a texel; nothing is drawn again that did not change; and
//! whatever is asked for, there is an answer.

mod cache;
mod cascade_ends;
mod cascades;
mod close_lamps;
mod contacts;
mod creases;
mod dungeon;
mod faint;
mod far_worlds;
mod filters;
mod format_steps;
mod holes;
mod matrix_faces;
mod matrix_twins;
mod models;
mod peeling;
mod refusals;
pub mod scenes;
mod surfaces;
mod twins;
mod wide_grounds;
