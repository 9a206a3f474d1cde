//! The stages of the memory for textures, and the system that shares it.

use bevy_ecs::prelude::*;

use super::memory::TextureMemory;
use crate::sets::FrameLights;

/// The stages of the memory for textures within
/// [`BuildTechniques`](crate::schedule::AntumbraSystems::BuildTechniques), chained. A technique whose textures count
/// towards [`TextureMemory::limit`] has a system in the first and one in the last set.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureMemorySystems {
    /// After this set [`TextureMemory`] knows the wants of the lights of every technique.
    Ask,
    /// After this set [`TextureMemory`] holds what every light gets in this frame.
    Share,
    /// After this set the techniques have built what fits into the textures that they got.
    Build,
}

/// Shares the memory for textures among the lights of all techniques.
///
/// Set: `BuildTechniques`, in [`TextureMemorySystems::Share`]. Reads [`FrameLights`]; writes [`TextureMemory`]. Cost:
/// O(wants log wants) while they fit; O(wants²) while they do not.
pub fn share_textures(mut memory: ResMut<TextureMemory>, lights: Res<FrameLights>) {
    memory.share(&lights);
}

/// Adds the stages to a schedule, within `within`.
pub fn add(schedule: &mut Schedule, within: impl SystemSet) {
    use TextureMemorySystems::{Ask, Build, Share};
    schedule.configure_sets((
        (Ask, Share, Build).chain().in_set(within.intern()),
        // The order does not matter, because the wants are sorted.
        Ask.ambiguous_with(Ask),
    ));
    schedule.add_systems(share_textures.in_set(Share));
}
