//! The plugin in headless games of Bevy's.
#![allow(
    clippy::duplicate_mod,
    reason = "the example and the tests each have an app without a window"
)]

#[path = "../gpu/harness/mod.rs"]
mod core_harness;

mod bad_input;
mod beside_bevy;
mod cameras;
mod cells;
mod copied;
mod cut_outs;
mod depth;
mod diagnostics;
mod drawn;
mod foreign;
mod forward;
mod gizmos;
mod harness;
mod interval_maps;
mod lifetimes;
mod light_model;
mod light_textures;
mod many_lights;
mod map_techniques;
mod minimal;
mod models;
mod reports;
mod runs;
mod scaled;
mod selection;
mod setup;
mod shading;
mod shadows;
mod shared;
mod standalone;
mod stripes;
mod sync;
mod targets;
mod transforms;
