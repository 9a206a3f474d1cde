//! The sets in which the systems of techniques run.

use bevy_ecs::prelude::*;

/// The set of the systems that build the techniques' geometry. It is in
/// [`BuildTechniques`](crate::schedule::AntumbraSystems::BuildTechniques) and holds all systems of that set.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TechniqueSystems;

/// The set of the systems that find out which objects a technique leaves to a second technique of the light
/// ([`Technique::left_to_others`](super::Technique::left_to_others)). It is in
/// [`CollectSets`](crate::schedule::AntumbraSystems::CollectSets), after the techniques of the lights were chosen and before
/// the sets of the lights are computed.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LeavingSystems;
