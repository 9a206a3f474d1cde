//! One limit on the memory of all techniques' textures, whichever techniques ask.
//!
//! ```text
//! each technique: ask ──► share_textures: one plan for all ──► each technique: read its grants, build
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `memory` | [`TextureMemory`]: the limit, and what each light asked for and got in this frame |
//! | `share_out` | the rule by which the memory is shared |
//! | `systems` | the stages that techniques join, and the system that shares |
//! | `report` | reports about lights that got less than they asked for |
//!
//! A technique adds a system in the set [`TextureMemorySystems::Ask`] that calls [`TextureMemory::ask`] for each of its
//! lights, and reads [`TextureMemory::grant`] in the set [`TextureMemorySystems::Build`].

pub(crate) mod memory;
pub(crate) mod report;
pub(crate) mod share_out;
pub(crate) mod systems;

pub use memory::{Shortage, TextureMemory, TextureShortage};
pub use share_out::{Storage, TextureGrant, TextureWant};
pub use systems::TextureMemorySystems;
