//! The one call that adds a technique.

use super::technique::Technique;

/// Takes shadow techniques: a world with its schedule, a plain [`App`](bevy_app::App), an app of Bevy's.
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
    /// Lights with the component `T` are shadowed by its technique. A technique that is there already is not added again.
    fn add_technique<T: Technique>(&mut self) -> &mut Self;
}
