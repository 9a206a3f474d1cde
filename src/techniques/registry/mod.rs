//! The trait of shadow techniques, and the list of the techniques that a world knows.
//!
//! A technique is a component on a light that implements [`Technique`]. [`Row::of`] makes a row of it, which
//! has no type parameter, and [`Techniques`] holds the rows of a world. Code that treats all techniques alike
//! uses the rows: the choice of a light's technique, the renderer, the Bevy adapter, scene files, statistics
//! and reports. A new technique of the crate is one folder and one line in [`add_builtin`]. A technique of
//! another crate is added by one call of [`AddTechnique::add_technique`].
//!
//! | file | holds |
//! | --- | --- |
//! | `technique` | the trait |
//! | `builtin` | the list of the crate's techniques |
//! | `add_technique` | the call that adds a technique |
//! | `row` | the trait without its type, and settings of any technique |
//! | `techniques` | the rows of a world |
//! | `companions` | a second technique of a light, for what the first one does not know |
//! | `choose` | the choice of a light's technique in each frame |
//! | `refusal` | the reasons why a technique does not shadow a light |
//! | `statistics` | named values that a technique reports of its lights and of the frame |
//! | `texels` | texels that a surface covers in a technique's pictures |
//! | `report` | reports of all techniques |
//! | `systems` | the sets in which the systems of techniques run |
//! | `gpu_row`, `recorders` | recorders and shaders of the rows (feature `render`) |

mod add_technique;
mod builtin;
pub(crate) mod choose;
pub(crate) mod companions;
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
mod texels;

pub use add_technique::AddTechnique;
pub use builtin::add_builtin;
pub use choose::choose_techniques;
pub use refusal::{FileError, Refusal};
pub use row::{Row, Settings};
pub use statistics::{Statistic, Statistics};
pub use systems::{LeavingSystems, TechniqueSystems};
pub use technique::Technique;
pub use techniques::{Techniques, add_row};
pub use texels::{SurfacePatch, TexelLookup};
