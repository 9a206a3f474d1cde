//! The parts of the renderer on wgpu that belong to no technique.
//!
//! | folder | holds |
//! | --- | --- |
//! | `gpu` | tools on top of wgpu: buffers, bind groups, timings, read-back |
//! | `pools` | meshes, materials, objects and lights in buffers |
//! | `frame` | one frame: draw lists, targets, and the passes in their order (`frame/record.rs`) |
//! | `light_model` | the GPU side of the light model |
//! | `nodes` | the passes that no technique owns, one file each |
//!
//! A technique joins the frame with a [`Recorder`].

pub(crate) mod context;
pub(crate) mod frame;
pub(crate) mod gpu;
pub(crate) mod light_function;
pub(crate) mod light_model;
pub(crate) mod nodes;
pub(crate) mod pools;
pub(crate) mod recorder;
pub(crate) mod recorders;
pub(crate) mod renderer;
pub(crate) mod report;
pub(crate) mod resident;
pub(crate) mod settings;
pub(crate) mod shaders;

pub use context::{RenderContext, RenderError, RequestedFeatures};
pub use frame::draw_list::{Batch, Variant};
pub use frame::frame_data::{
    ActiveCompanion, ActiveLight, FrameData, LightShadow, LightSlot, MatrixWork, TechniqueIndex, Viewport,
};
pub use frame::hosted::{HostFrame, HostView, stencil_lit, stencil_shadowed};
pub use frame::pixel_measures::SurfacePlane;
pub use frame::record::FrameOutputs;
pub use frame::targets::{
    FrameTargets, MASK_FORMAT, MaskTargets, RADIANCE_FORMAT, RECEIVER_PLANE_FORMAT, RadianceTarget,
    create_target,
};
pub use gpu::pipeline_cache::{PipelineCache, PipelineDesc, Stage, Variants};
pub use gpu::readback;
pub use gpu::timings::{PassTime, Timings};
pub use light_function::{LightFunction, MULTIPLY};
pub use nodes::pipelines::{SURFACE_BUFFERS, VISIBILITY_FORMAT};
pub use nodes::surfaces::SurfaceResources;
pub use pools::materials::HostTexture;
pub use pools::meshes::OversizedMesh;
pub use recorder::{
    Leaves, Mark, PictureInput, PrepareInput, Receivers, RecordInput, Recorder, Resolve, ResolveInput,
    ShadowKind,
};
pub use recorders::{NoRecorder, Recorders};
pub use renderer::Renderer;
pub use resident::Gpu;
pub use settings::RenderSettings;
pub use shaders::{ShaderFile, Shaders};
/// The version of wgpu whose devices, encoders and views this crate takes. The types of another version of
/// wgpu do not fit.
pub use wgpu;
