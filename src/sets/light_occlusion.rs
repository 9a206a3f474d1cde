//! Set L of each light: what it reaches and may see.

use bevy_ecs::prelude::*;

use super::lights::FrameLights;

/// L = reach: there is no occlusion from the lights yet, and this step is where it takes objects out.
///
/// Set: `CollectSets`, after `collect_light_sets`.
pub fn collect_light_occlusion(mut frame: ResMut<FrameLights>) {
    for light in frame.lights.iter_mut().filter(|light| light.reach_written) {
        light.l.clone_from(&light.reach);
    }
}
