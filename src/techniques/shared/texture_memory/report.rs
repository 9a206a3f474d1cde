//! Reports about lights that got less memory for textures than they asked for.

use bevy_ecs::prelude::*;

use super::memory::{Shortage, TextureMemory};
use crate::reports::Reports;

/// Raises the topic `texture_memory`.
pub fn report_texture_memory(world: &World, reports: &mut Reports) {
    let mut round = reports.round("texture_memory");
    for short in world.resource::<TextureMemory>().shortages() {
        let (code, effect, advice) = match short.shortage {
            Shortage::Coarser { .. } => (1, "is poorer than asked for", "ask for lower resolutions"),
            Shortage::Shared { .. } => (2, "is poorer than asked for", "use fewer lights with textures"),
            Shortage::Nothing => (3, "is missing", "use fewer lights with textures"),
        };
        round.state(
            Some(short.entity),
            code,
            format_args!(
                "The light's shadow by {} {effect}: {}. Raise `TextureMemory::limit` (in Bevy `AntumbraSettings::texture_memory`), or {advice}.",
                short.asker, short.shortage
            ),
        );
    }
}
