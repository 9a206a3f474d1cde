//! Cookies and luminaire profiles on the GPU. They are multiplied into the light's mask by a pass of their own, which
//! only lights with such a texture pay for.
//!
//! | file | holds |
//! | --- | --- |
//! | `function` | the light function: one pass for each light that has a texture |
//! | `constants` | the constants of one light |
//! | `store` | textures of cookies and profiles, which all views share |
//! | `groups` | bind groups, kept while their textures stay the same |

pub(crate) mod constants;
pub(crate) mod function;
pub(crate) mod groups;
pub(crate) mod store;
