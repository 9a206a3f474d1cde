//! The call that adds a technique.

use super::technique::Technique;

/// Adds shadow techniques to a world with its schedule, to a plain [`App`](bevy_app::App) or to a Bevy app.
///
/// ```
/// use antumbra::prelude::*;
/// use antumbra::techniques::AddTechnique;
/// use bevy_ecs::prelude::*;
/// # type MyShadow = StencilVolume;
///
/// let mut app = bevy_app::App::new();
/// app.add_plugins(AntumbraPlugin);
/// app.add_technique::<MyShadow>();
///
/// // An engine without an `App`:
/// let mut world = World::new();
/// antumbra::schedule::init_resources(&mut world);
/// let mut schedule = antumbra::schedule::standalone_schedule();
/// (&mut world, &mut schedule).add_technique::<MyShadow>();
/// ```
pub trait AddTechnique {
    /// Adds a technique, which then shadows lights with the component `T`. A technique that is known already
    /// is not added again.
    fn add_technique<T: Technique>(&mut self) -> &mut Self;
}
