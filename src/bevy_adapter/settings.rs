//! What a game sets once.

use bevy::ecs::prelude::*;

/// How the adapter works. Insert it before or after the plugin, or change it at any time.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraSettings {
    /// Meshes of at most so many triangles are made ready in the frame in which they appear; larger ones on the threads
    /// of the `AsyncComputeTaskPool`. Until it is ready, a mesh is lit and casts no shadow. `usize::MAX` waits for all,
    /// which makes frames repeatable.
    pub immediate_triangles: usize,
    /// Gives other 3D cameras a deferred prepass too: opaque materials are deferred by default, and without it Bevy shows
    /// none of them. Turn it off where other cameras see forward materials alone.
    pub defer_other_cameras: bool,
}

impl Default for AntumbraSettings {
    fn default() -> Self {
        Self {
            immediate_triangles: 2048, // about a millisecond's work; by eye
            defer_other_cameras: true,
        }
    }
}
