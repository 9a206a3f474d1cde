//! All of wgpu that no technique owns.
//!
//! What lives long ([`RenderContext`], [`Shaders`], pipelines, pools) is apart from what a frame changes
//! ([`systems`] fill it, [`frame`] reads it). Passes are recorded by [`nodes`] in the order that
//! [`frame`] lists.

pub mod bind_groups;
pub mod buffers;
pub mod canvas;
pub mod context;
pub mod draw_list;
pub mod frame;
pub mod frame_data;
mod front_lights;
mod front_surfaces;
pub mod gpu_types;
pub mod hosted;
pub mod kept;
pub mod lights;
pub mod materials;
pub mod meshes;
pub mod mipmaps;
pub mod nodes;
pub mod objects;
pub mod pipelines;
pub mod readback;
pub mod renderer;
pub mod settings;
pub mod shaders;
pub mod slots;
pub mod stencil_only;
pub mod surface_pass;
pub mod systems;
pub mod targets;
pub mod technique;
pub mod timings;

pub use context::{RenderContext, RenderError, RequestedFeatures};
pub use renderer::Renderer;
pub use settings::RenderSettings;
pub use shaders::Shaders;
pub use targets::{FrameTargets, RadianceTarget};
/// The version of wgpu whose devices, encoders and views all of this takes: types of another are other types.
pub use wgpu;
