//! Settings of the adapter.

use bevy::ecs::prelude::*;

use crate::techniques::TextureMemory;

/// Settings of the adapter. Insert the resource before or after the plugin, or change it at any time.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraSettings {
    /// Largest number of triangles of a mesh that is made ready in the frame in which it appears. Larger
    /// meshes are made ready on the threads of the `AsyncComputeTaskPool`; until then they are lit but cast
    /// no shadow, and those that changed cast the shadow of their last shape. Higher values make shadows
    /// appear sooner, but lengthen frames in which meshes appear.
    /// `usize::MAX` waits for all meshes, which makes frames repeatable. Default: 2048.
    pub immediate_triangles: usize,
    /// Limit on the memory of the textures of all shadow techniques, bytes, for each camera with shadows. Beyond it, the
    /// lights with the most bytes for each pixel that they reach get coarser shadows first; then the least visible lose
    /// their textures. The log names them. Higher values keep shadows sharp with many lights. Default: 256 MiB.
    pub texture_memory: u64,
}

impl Default for AntumbraSettings {
    fn default() -> Self {
        Self {
            immediate_triangles: 2048, // about a millisecond's work; by eye
            texture_memory: TextureMemory::default().limit,
        }
    }
}
