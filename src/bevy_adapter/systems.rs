//! Where our systems run, for those who order theirs against them.

use bevy::ecs::prelude::*;

/// Sets in the main world.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AntumbraMainSystems {
    /// `PostUpdate`: after this set marked cameras have no MSAA, and cameras that cannot show our shadows have been
    /// warned of.
    CheckCameras,
    /// `PostUpdate`: after this set the [`MeshLibrary`](super::MeshLibrary) knows the meshes of this frame.
    CollectMeshes,
}

/// Sets in `ExtractSchedule`, chained.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AntumbraExtractSystems {
    /// After this set every marked camera has a mirror, and touched lights are listed.
    Collect,
    /// After this set the mirrors hold the game's scene of this frame.
    Sync,
}

/// Sets in the render world.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AntumbraRenderSystems {
    /// `Render`, in `PrepareResources`: after this set each view has its sets, silhouettes and buffers of this frame.
    Prepare,
    /// `Core3d`, in the main pass, after Bevy's deferred lighting: after this set the managed lights shine.
    Light,
}

/// The app has Bevy's renderer, and the adapter is in it: nothing of the core runs in the main world.
#[derive(Resource)]
pub struct Installed;
