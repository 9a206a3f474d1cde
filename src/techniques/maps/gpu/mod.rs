//! The recorder of maps.
//!
//! | file | holds |
//! | --- | --- |
//! | `recorder` | which draws and lookups a frame needs |
//! | `passes` | the passes of one light's map |
//! | `draws` | casters of a face as draw calls |
//! | `pipelines`, `layouts` | pipelines and bind groups |
//! | `pool` | textures of kept and shared maps |
//! | `constants` | what the lookup reads of a light |

pub(crate) mod constants;
mod draws;
mod layouts;
mod passes;
pub(crate) mod pipelines;
mod pool;
pub(crate) mod recorder;
