//! Cookies: pictures before a light, which colour and shape it.
//!
//! | file | holds |
//! | --- | --- |
//! | `cube` | pictures that are cubes around a light |
//! | `image` | the picture, linear, and the reading of files |
//! | `levels` | its mip levels |
//! | `component` | the component, and what can be wrong with it |
//! | `placing` | from a surface to the picture: projection, turn, offset and size |

mod component;
pub(crate) mod cube;
mod image;
mod levels;
pub(crate) mod placing;

pub use component::{Cookie, CookieError};
pub use image::{CookieImage, CookieImageError};
