//! Geometry, sets, silhouettes, schedule and the ray caster: everything that needs neither a GPU nor a file.

mod commands;
#[cfg(feature = "reference")]
mod exchanged_looks;
mod import_circles;
mod inverted_hulls;
mod invisible;
mod kept_volumes;
mod layers;
mod light_hull;
#[cfg(feature = "reference")]
mod occlusion_harness;
#[cfg(feature = "reference")]
mod occlusion_never_hides;
mod occlusion_texture;
mod readme;
#[cfg(feature = "reference")]
mod reference;
mod reports;
mod schedule_order;
mod sets_at_scale;
mod sets_bad_input;
mod sets_harness;
mod sets_known_answers;
mod sets_never_drop;
mod silhouette_closed;
mod smoothie;
mod techniques;
mod texture_memory;
