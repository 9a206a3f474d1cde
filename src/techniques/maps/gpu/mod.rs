//! The recorder of maps.
//!
//! | file | holds |
//! | --- | --- |
//! | `recorder` | which draws and lookups a frame needs |
//! | `passes` | the passes of one light's map |
//! | `draws` | casters of a face as draw calls |
//! | `pipelines`, `layouts` | pipelines and bind groups |
//! | `recorded` | which faces are drawn, and what a dropped encoder takes back |
//! | `pool` | textures of kept and shared maps |
//! | `constants` | what the lookup reads of a light |

pub(crate) mod constants;
mod draws;
pub(crate) mod gpu_types;
mod layouts;
mod passes;
mod pipelines;
mod pool;
mod recorded;
pub(crate) mod recorder;
