//! A report about a world whose record of removed components is never cleared, and so grows with every frame.

use bevy_ecs::prelude::*;

use crate::reports::Reports;

/// Frames without a call of [`World::clear_trackers`] that are reported. Fewer take a few kilobytes, which matter to no
/// program that draws so few frames.
const REPORTED: usize = 1000;

/// Raises the report of the topic `world`. It must be called once a frame while [`Reports`] is taken out of the world: each
/// time, the world remembers one removal of it until trackers are cleared.
pub fn report_uncleared(world: &World, reports: &mut Reports) {
    let mut round = reports.round("world");
    let removals = world
        .component_id::<Reports>()
        .and_then(|id| world.removed_components().get(id));
    if removals.is_some_and(|removals| removals.len() > REPORTED) {
        round.raise(None, 1, || {
            "The world keeps every removal of a component, and grows with each frame. Call `World::clear_trackers` once a \
             frame, after all schedules, as an `App` does."
                .to_owned()
        });
    }
}
