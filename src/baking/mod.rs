//! Baking of occlusion interval maps on the CPU (feature `reference`).
//!
//! ```text
//! World ──► surfaces ──► unwrap ──► charts ──► texels ──► rays ──► intervals ──► pages ──► folder
//!           that stand    second set,           a point     256 of      per texel    packed by
//!           still         or a new one          for each    each                     pairs needed
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `bake`, `job` | [`bake_intervals`] and [`bake_into`], which do all of it |
//! | `settings` | input and output of a bake |
//! | `key` | the hash by which an interrupted bake and finished maps are recognized |
//! | `surfaces` | what stands still in a world |
//! | `unwrap`, `own_set`, `new_set`, `overlap`, `chart` | surfaces laid flat, and cut into charts |
//! | `texels` | the surface point that each texel stands for |
//! | `trace` | the rays of a texel |
//! | `pack` | charts on pages |
//! | `partial` | the file from which an interrupted bake is resumed |
//!
//! Rays are those of [`reference`](crate::reference), in `f64`: a map is as exact as the truth, at its texels.
//!
//! ```no_run
//! use antumbra::baking::{BakeSettings, bake_into};
//! use antumbra::scene::LightPath;
//! # let mut world = bevy_ecs::prelude::World::new();
//! // After a frame, so that transforms are propagated:
//! let path = LightPath::Sun { latitude_degrees: 50.0, day: 172.0, hours: [4.0, 20.0] };
//! let settings = BakeSettings::default();
//! let bake = bake_into("maps".as_ref(), &mut world, &path, &settings, |progress| {
//!     println!("{} of {} texels", progress.done, progress.all);
//! })?;
//! for note in &bake.notes {
//!     println!("{note}");
//! }
//! # Ok::<(), antumbra::baking::BakeError>(())
//! ```
//!
//! Source: Donnelly & Demers 2004, GPU Gems, section 13.3.

pub(crate) mod bake;
pub(crate) mod chart;
pub(crate) mod job;
pub(crate) mod key;
pub(crate) mod new_set;
pub(crate) mod overlap;
pub(crate) mod own_set;
pub(crate) mod pack;
pub(crate) mod partial;
pub(crate) mod settings;
pub(crate) mod surfaces;
pub(crate) mod texels;
pub(crate) mod trace;
pub(crate) mod unwrap;

pub use bake::{bake_intervals, bake_into};
pub use settings::{Bake, BakeError, BakeNote, BakeProgress, BakeSettings};
pub use unwrap::UnwrapNote;
