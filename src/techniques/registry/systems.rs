//! The set in which the systems of techniques run.

use bevy_ecs::prelude::*;

/// The set of the systems that build the techniques' geometry. It is in
/// [`BuildTechniques`](crate::schedule::AntumbraSystems::BuildTechniques) and holds all systems of that set.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TechniqueSystems;
