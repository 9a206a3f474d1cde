//! Where the systems of techniques run.

use bevy_ecs::prelude::*;

/// The systems that build what the techniques draw; all of
/// [`BuildTechniques`](crate::schedule::AntumbraSystems::BuildTechniques).
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TechniqueSystems;
