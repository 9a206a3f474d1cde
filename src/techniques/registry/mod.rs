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
//! | `builtin` | the one list |
//! | `add_technique` | the one call that adds a technique |
//! | `row` | the trait without its type, and settings of any technique |
//! | `techniques` | the rows of a world |
//! | `choose` | which technique shadows a light in this frame |
//! | `refusal` | why a technique does not shadow a light |
//! | `statistics` | what a technique counts |
//! | `report` | reports of all techniques |
//! | `systems` | where the systems of techniques run |
//! | `gpu_row`, `recorders` | recorders and shaders of the rows (feature `render`) |

mod add_technique;
mod builtin;
pub(crate) mod choose;
#[cfg(feature = "render")]
mod gpu_row;
#[cfg(feature = "render")]
pub(crate) mod recorders;
mod refusal;
pub(crate) mod report;
mod row;
mod statistics;
mod systems;
mod technique;
mod techniques;

pub use add_technique::AddTechnique;
pub use builtin::add_builtin;
pub use choose::choose_techniques;
pub use refusal::Refusal;
pub use row::{Row, Settings};
pub use statistics::{Statistic, Statistics};
pub use systems::TechniqueSystems;
pub use technique::Technique;
pub use techniques::{Techniques, add_row};
