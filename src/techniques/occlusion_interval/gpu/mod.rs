//! The recorder of occlusion interval maps.
//!
//! | file | holds |
//! | --- | --- |
//! | `recorder` | the draws that a frame needs, and the pass that records them |
//! | `draws` | the draws of one light |
//! | `gpu_maps` | textures and vertices of one scene |
//! | `welded` | vertices that triangles share |
//! | `footprint` | the texels that a triangle reads |
//! | `runs` | triangles that are drawn or left out together |
//! | `pipelines` | pipelines and bind groups |
//! | `gpu_types` | structs that the shader reads |

pub(crate) mod draws;
pub(crate) mod footprint;
pub(crate) mod gpu_maps;
pub(crate) mod gpu_types;
pub(crate) mod pipelines;
pub(crate) mod recorder;
pub(crate) mod runs;
pub(crate) mod welded;

use crate::render::shaders::{ShaderFile, shader_files};

/// The WGSL files of occlusion interval maps.
pub(crate) const SHADERS: &[ShaderFile] = shader_files!["techniques/occlusion_interval/resolve.wgsl"];
