//! What a shadow technique is, and the list of those that a world knows.
//!
//! A technique is a component on a light that implements [`Technique`]. [`Row::of`] makes a row of it, which has no type
//! parameter; [`Techniques`] holds the rows of a world. Everything that must treat all techniques alike goes through the
//! rows: the choice of the light's technique, the renderer, Bevy, scene files, statistics, reports. A new technique of
//! the crate is one folder and one line in [`add_builtin`]; a new technique of somebody else is one call of
//! [`AddTechnique::add_technique`].
//!
//! | file | holds |
//! | --- | --- |
//! | `technique` | the trait |
//! | `row` | the trait without its type, and settings of any technique |
//! | `choose` | which technique shadows a light in this frame |
//! | `refusal` | why a technique does not shadow a light |
//! | `statistics` | what a technique counts |
//! | `report` | reports of all techniques |
//! | `gpu` | the recorders of the rows (feature `render`) |

pub(crate) mod choose;
#[cfg(feature = "render")]
pub(crate) mod gpu;
mod refusal;
pub(crate) mod report;
mod row;
mod statistics;
mod technique;

use bevy_ecs::prelude::*;

pub use choose::choose_techniques;
#[cfg(feature = "render")]
pub use gpu::RecorderInput;
pub use refusal::Refusal;
pub use row::{Row, Settings};
pub use statistics::{Statistic, Statistics};
pub use technique::Technique;

use super::{OmniMap, PenumbraWedge, ShadowMap, StencilVolume};
use choose::RefusedLight;

/// The systems that build what the techniques draw; all of
/// [`BuildTechniques`](crate::schedule::AntumbraSystems::BuildTechniques).
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TechniqueSystems;

/// The one list: adds the crate's own techniques. Where a light has several, the first that stands here shadows it.
pub fn add_builtin(to: &mut impl AddTechnique) {
    to.add_technique::<StencilVolume>();
    to.add_technique::<PenumbraWedge>();
    to.add_technique::<ShadowMap>();
    to.add_technique::<OmniMap>();
}

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

/// The techniques that a world knows, those of the crate first.
#[derive(Resource, Clone, Debug)]
pub struct Techniques {
    rows: Vec<Row>,
    refused: Vec<RefusedLight>,
}

impl Default for Techniques {
    /// The crate's own techniques.
    fn default() -> Self {
        let mut techniques = Self {
            rows: Vec::new(),
            refused: Vec::new(),
        };
        add_builtin(&mut techniques);
        techniques
    }
}

impl AddTechnique for Techniques {
    fn add_technique<T: Technique>(&mut self) -> &mut Self {
        self.add(Row::of::<T>());
        self
    }
}

impl AddTechnique for (&mut World, &mut Schedule) {
    fn add_technique<T: Technique>(&mut self) -> &mut Self {
        let (world, schedule) = self;
        add_row(Row::of::<T>(), world, schedule);
        self
    }
}

/// Adds a technique to a world and to the schedule of its frame, unless the world knows the technique.
pub fn add_row(row: Row, world: &mut World, schedule: &mut Schedule) {
    world.init_resource::<Techniques>();
    if world.resource_mut::<Techniques>().add(row) {
        row.init(world);
        row.add_systems(schedule);
    }
}

impl Techniques {
    /// Adds a row; `false` if the technique is in the list.
    fn add(&mut self, row: Row) -> bool {
        let is_new = !self.rows.contains(&row);
        if is_new {
            self.rows.push(row);
        }
        is_new
    }

    /// The techniques in their order.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The technique of a name, in snake case.
    pub fn named(&self, name: &str) -> Option<Row> {
        self.rows.iter().copied().find(|row| row.name() == name)
    }

    /// The techniques whose components are on an entity; the first shadows the light.
    pub fn on<'a>(&'a self, entity: EntityRef<'a>) -> impl Iterator<Item = Row> + 'a {
        self.rows.iter().copied().filter(move |row| row.is_on(&entity))
    }

    /// Takes all techniques off a light. Gives them, in their order, so that they can be put back
    /// ([`Settings::insert`]).
    pub fn take(&self, light: &mut EntityWorldMut) -> Vec<Settings> {
        let settings: Vec<Settings> = self
            .rows
            .iter()
            .filter_map(|row| row.settings_of(&light.as_readonly()))
            .collect();
        for row in &self.rows {
            row.remove(light);
        }
        settings
    }
}
