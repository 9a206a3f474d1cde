//! Luminaire profiles: how the intensity of a light depends on the direction, as a photometer measured it.
//!
//! | file | holds |
//! | --- | --- |
//! | `light_profile` | the component, and the reading of files |
//! | `ies`, `eulumdat` | readers of the two formats that manufacturers publish |
//! | `numbers` | reading of numbers, each with its line |
//! | `measured` | the planes of a file, and their symmetries |
//! | `table` | intensity by angle, and its evaluation |
//! | `error` | what can be wrong with a file, and in which line |
//!
//! The readers are the crate's own, because those that the registry offers under a permissive licence do not say
//! which line of a file is wrong.

mod error;
mod eulumdat;
mod ies;
mod light_profile;
mod measured;
mod numbers;
pub(crate) mod table;

pub use error::{ProfileError, ProfileFault};
pub use light_profile::{LightProfile, LoadProfileError};
pub use table::ProfileTable;
