//! Counters of computations, for statistics and for the test that a steady frame computes nothing.

use bevy_ecs::prelude::*;

/// Work since the start of the app. All systems of the sets write it.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SetWork {
    /// How often [`Objects`](super::Objects) was rebuilt.
    pub layouts: u64,
    /// Number of objects written because they moved.
    pub objects_written: u64,
    /// How often the [`View`](super::View) changed.
    pub views: u64,
    /// Number of bitset words tested against the frustum.
    pub frustum_words: u64,
    /// Number of depth buffers drawn, of the camera and of lights.
    pub depth_buffers: u64,
    /// Number of tests whether an object is occluded.
    pub occlusion_tests: u64,
    /// Number of objects projected to the screen.
    pub objects_projected: u64,
    /// Number of bitset words tested against the volumes of lights.
    pub light_words: u64,
    /// How often the illumination set of a light was computed.
    pub illuminations: u64,
    /// How often the shadow set of a light was computed.
    pub shadows: u64,
}
