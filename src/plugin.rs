//! System sets, schedules, registration: the one file that knows every system.

use bevy_ecs::prelude::*;

/// What is true after each stage of a frame. Chained in this order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AntumbraSystems {
    /// After this set every object's [`WorldBounds`](crate::scene::WorldBounds) are those of this frame's pose.
    UpdateBounds,
    /// After this set the view and every light have their sets F, V, L, I, S, scissors and depth bounds.
    CollectSets,
    /// After this set every caster that some light needs has its silhouette.
    BuildSilhouettes,
    /// After this set every technique has its geometry on the CPU.
    BuildTechniques,
    /// After this set the GPU holds all that the frame draws.
    PrepareGpu,
    /// After this set the frame is drawn.
    Render,
}
