//! One frame: the draws, the targets, and the order of the passes.
//!
//! | file | holds |
//! | --- | --- |
//! | `prepare`, `prepare_draws` | the systems that fill the frame |
//! | `resources` | targets and buffers that a frame needs |
//! | `record` | the passes in their order: start reading here |
//! | `record_lights` | the passes of one light |
//! | `companions` | the passes of a second technique of a light |
//! | `recording` | the encoder, targets and timers that all passes record with |
//! | `required` | the pipelines that a frame needs |
//! | `frame_data`, `draw_list` | draws and lights of the frame |
//! | `labels` | the labels of the lights' passes |
//! | `targets`, `canvas` | the textures that passes write |
//! | `front_surfaces`, `front_lights` | the front layer of blended surfaces |
//! | `pixel_measures` | what a frame costs at each pixel, for debug views |
//! | `hosted` | frames that light the surfaces of a host's renderer |

pub(crate) mod canvas;
pub(crate) mod companions;
pub(crate) mod draw_list;
pub(crate) mod frame_data;
pub(crate) mod front_lights;
pub(crate) mod front_surfaces;
pub(crate) mod hosted;
pub(crate) mod labels;
pub(crate) mod pixel_measures;
pub(crate) mod prepare;
pub(crate) mod prepare_draws;
pub(crate) mod record;
pub(crate) mod record_lights;
pub(crate) mod recording;
pub(crate) mod required;
pub(crate) mod resources;
pub(crate) mod targets;
