//! Counters of what was computed, for statistics and for the claim that a steady frame computes nothing.

use bevy_ecs::prelude::*;

/// Work since the start, written by all systems of the sets.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SetWork {
    /// Times that [`Objects`](super::Objects) was rebuilt.
    pub layouts: u64,
    /// Objects written because they moved.
    pub objects_written: u64,
    /// Times that the [`View`](super::View) changed.
    pub views: u64,
    /// Bitset words tested against the frustum.
    pub frustum_words: u64,
    /// Depth buffers drawn, of the camera and of lights.
    pub depth_buffers: u64,
    /// Objects tested for being occluded.
    pub occlusion_tests: u64,
    /// Objects projected to the screen.
    pub objects_projected: u64,
    /// Bitset words tested against lights' volumes.
    pub light_words: u64,
    /// Lights whose illumination set was computed.
    pub illuminations: u64,
    /// Lights whose shadow set was computed.
    pub shadows: u64,
}
