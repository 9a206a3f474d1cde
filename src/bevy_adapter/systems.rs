//! System sets of the adapter. Order other systems before or after them.

use bevy::ecs::prelude::*;

/// Sets in the main world.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AntumbraMainSystems {
    /// A set of `PostUpdate`. After this set marked cameras have no MSAA, and warnings about cameras that
    /// cannot show shadows have been logged.
    CheckCameras,
    /// A set of `PostUpdate`. After this set the [`MeshLibrary`](super::MeshLibrary) knows the meshes of this
    /// frame.
    CollectMeshes,
}

/// Sets in `ExtractSchedule`, chained.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AntumbraExtractSystems {
    /// After this set every marked camera has a mirror, and lights whose technique changed are listed.
    Collect,
    /// After this set the mirrors hold the game's scene of this frame.
    Sync,
}

/// Sets in the render world.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AntumbraRenderSystems {
    /// A set of `Render`, in `PrepareResources`. After this set each view has its sets, silhouettes and
    /// buffers of this frame.
    Prepare,
    /// A set of `Core3d`, in the main pass, after Bevy's deferred lighting. After this set the picture has
    /// the managed lights.
    Light,
}

/// Marks an app with Bevy's renderer in which the adapter is installed. The core's systems do not run in its
/// main world.
#[derive(Resource)]
pub struct Installed;
