//! The recorder of smoothies.
//!
//! | file | holds |
//! | --- | --- |
//! | `recorder` | the smoothies and lookups that a frame needs |
//! | `plans` | smoothies of each face, from the silhouettes of its casters |
//! | `passes` | the passes of one light's smoothies, and the lookup |
//! | `pipelines` | pipelines and bind groups |

pub(crate) mod passes;
pub(crate) mod pipelines;
pub(crate) mod plans;
pub(crate) mod recorder;

use crate::render::shaders::{ShaderFile, shader_files};

/// The WGSL files of smoothies. Those of maps come first, because smoothies import them.
pub(crate) const SHADERS: &[ShaderFile] = shader_files![
    "common/map.wgsl",
    "common/map_site.wgsl",
    "common/smoothie.wgsl",
    "techniques/maps/matrix.wgsl",
    "techniques/maps/crease.wgsl",
    "techniques/maps/map_caster.wgsl",
    "techniques/maps/caster.wgsl",
    "techniques/maps/convert.wgsl",
    "techniques/maps/frustum.wgsl",
    "techniques/maps/resolve.wgsl",
    "techniques/smoothie/edge.wgsl",
    "techniques/smoothie/resolve.wgsl",
];
