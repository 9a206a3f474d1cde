//! The recorder of occlusion textures.
//!
//! | file | holds |
//! | --- | --- |
//! | `recorder` | the pictures and lookups that a frame needs |
//! | `passes` | the passes of one light's pictures, and the lookup |
//! | `pipelines` | pipelines and bind group layouts |
//! | `textures` | the pictures of each light, with the levels of their filter |
//! | `maker` | makes these textures, and lists the passes that fill them |
//! | `texture_pool` | the textures that are in use |

pub(crate) mod maker;
pub(crate) mod passes;
pub(crate) mod pipelines;
pub(crate) mod recorder;
mod texture_pool;
pub(crate) mod textures;

use crate::render::shaders::{ShaderFile, shader_files};

/// The WGSL files of occlusion textures.
pub(crate) const SHADERS: &[ShaderFile] = shader_files![
    "techniques/maps/map_caster.wgsl",
    "techniques/occlusion_texture/kernel.wgsl",
    "techniques/occlusion_texture/caster.wgsl",
    "techniques/occlusion_texture/filter.wgsl",
    "techniques/occlusion_texture/resolve.wgsl",
];
