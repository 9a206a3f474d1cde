//! What a game sets once.

use bevy::ecs::prelude::*;

/// How the adapter works. Insert it before or after the plugin, or change it at any time.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraSettings {
    /// Meshes of at most so many triangles are made ready in the frame in which they appear; larger ones on the threads
    /// of the `AsyncComputeTaskPool`. Until it is ready, a mesh is lit and casts no shadow. `usize::MAX` waits for all,
    /// which makes frames repeatable.
    pub immediate_triangles: usize,
}

impl Default for AntumbraSettings {
    fn default() -> Self {
        Self {
            immediate_triangles: 2048, // about a millisecond's work; by eye
        }
    }
}
