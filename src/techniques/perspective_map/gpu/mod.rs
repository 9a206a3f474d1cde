//! The recorder of perspective maps: the maps are those of all techniques with maps, and blurred grounds are added.
//!
//! | file | holds |
//! | --- | --- |
//! | `recorder` | what a frame needs |
//! | `passes` | the passes of one light: colours of casters, blur, lookup |
//! | `pictures` | the textures of one light |
//! | `pipelines` | pipelines and bind groups |

pub(crate) mod gpu_types;
pub(crate) mod passes;
pub(crate) mod pictures;
pub(crate) mod pipelines;
pub(crate) mod recorder;

use crate::render::shaders::{ShaderFile, shader_files};

/// The WGSL files of perspective maps. Those of maps come first, because the others import them.
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
    "techniques/perspective_map/color.wgsl",
    "techniques/perspective_map/blur.wgsl",
    "techniques/perspective_map/ground.wgsl",
];
