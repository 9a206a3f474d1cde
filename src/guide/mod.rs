//! Pages on how to use the crate. Snippets in them are compiled and run as tests.
//!
//! | page | subject |
//! | --- | --- |
//! | [`engines`] | your own device, your own light shader, no GPU, glTF scenes |
//! | [`shot_file`] | all keys of shot files, which `examples/render` draws |
//! | [`own_technique`] | a technique of yours, in shot files, Bevy and statistics |
//! | [`cells_and_portals`] | what hides objects from cameras and lights |
//! | [`reports`] | what is refused, skipped or short, and what to do about it |
//! | [`limits`] | what does not work |

#[cfg(any(doc, all(doctest, feature = "render", feature = "gltf")))]
#[doc = include_str!("engines.md")]
pub mod engines {}

#[cfg(any(doc, all(doctest, feature = "render", feature = "gltf")))]
#[doc = include_str!("shot_file.md")]
pub mod shot_file {}

#[cfg(any(doc, all(doctest, feature = "render", feature = "gltf")))]
#[doc = include_str!("own_technique.md")]
pub mod own_technique {}

#[cfg(any(doc, all(doctest, feature = "render", feature = "gltf")))]
#[doc = include_str!("cells_and_portals.md")]
pub mod cells_and_portals {}

#[cfg(any(doc, all(doctest, feature = "render", feature = "gltf")))]
#[doc = include_str!("reports.md")]
pub mod reports {}

#[cfg(any(doc, all(doctest, feature = "render", feature = "gltf")))]
#[doc = include_str!("limits.md")]
pub mod limits {}
