//! The recorder of maps.
//!
//! | file | holds |
//! | --- | --- |
//! | `recorder` | the recorder: what lives long, and the order of a frame |
//! | `planning`, `plans` | the draws and lookups that a frame needs |
//! | `passes` | the passes of one light's map |
//! | `draws` | casters of a face as draw calls |
//! | `pipelines`, `layouts` | pipelines and bind groups |
//! | `recorded` | the faces that are drawn, and their withdrawal when an encoder is dropped |
//! | `pool` | textures of kept and shared maps |
//! | `constants` | the shader's constants of a light's map |

pub(crate) mod constants;
pub(crate) mod draws;
pub(crate) mod gpu_types;
pub(crate) mod layouts;
pub(crate) mod limit;
pub(crate) mod passes;
pub(crate) mod pipelines;
pub(crate) mod planning;
pub(crate) mod plans;
pub(crate) mod pool;
pub(crate) mod recorded;
pub(crate) mod recorder;

pub(crate) use limit::limit_to_device;

use crate::render::shaders::{ShaderFile, shader_files};

/// The WGSL files of maps.
pub(crate) const SHADERS: &[ShaderFile] = shader_files![
    "common/map.wgsl",
    "common/map_site.wgsl",
    "techniques/maps/matrix.wgsl",
    "techniques/maps/crease.wgsl",
    "techniques/maps/map_caster.wgsl",
    "techniques/maps/caster.wgsl",
    "techniques/maps/convert.wgsl",
    "techniques/maps/frustum.wgsl",
    "techniques/maps/resolve.wgsl",
];
