//! The depth of a picture that a host drew, as the depth that shadow volumes are counted against.
//!
//! Shader  `shaders/passes/host_depth.wgsl`
//! Groups  0 view, 2 material (not read), 3 host depth
//! Reads   the host's depth.  Writes  depth
//! Order   first of a hosted frame, in place of `ambient`
//!
//! Shadow volumes begin on surfaces. A host computes these with its own matrices, vertex shaders and roundings, so a near
//! cap and the surface that it lies on would be equal by luck. Therefore the host's depth is copied, and then the visible
//! set is drawn over it with our own vertex stage: wherever the host shows that surface, within roundings, its depth
//! becomes ours, and caps are equal to it by construction, with no bias. Where the host shows something else (a hole in a
//! texture, a surface that we do not know), its depth stays.

use std::sync::{Mutex, PoisonError};

use glam::DVec4;

use super::surface_pass::SurfacePass;
use super::surfaces::draw_batches;
use crate::render::frame::draw_list::Batch;
use crate::render::frame::hosted::HostView;
use crate::render::frame::recording::Recording;
use crate::render::gpu::bind_groups::{BindGroupLayouts, bind_in_order};
use crate::render::gpu::kept::Kept;
use crate::render::gpu::pipeline_cache::{EVERYWHERE, PipelineDesc, Stage};
use crate::render::pools::gpu_types;
use crate::render::{Gpu, RenderContext, RenderError};
use crate::sets::{ViewData, ViewDepth};

/// The pipeline of the copy, and what it reads.
#[derive(Debug)]
pub struct HostDepth {
    copy: wgpu::RenderPipeline,
    constants: wgpu::Buffer,
    /// Group 3, of the host's depth.
    group: Mutex<Kept<wgpu::TextureView, wgpu::BindGroup>>,
}

impl HostDepth {
    /// Takes the pipeline from the shared cache, and makes a view's own constants.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let fragment = Stage::new("passes/host_depth.wgsl", "copy");
        let desc = PipelineDesc::new("host depth", EVERYWHERE, Some(fragment))
            .with_groups([Some(&gpu.layouts.view), None, None, Some(&gpu.layouts.host)])
            .with_depth(
                gpu.context.depth_stencil_format(),
                true,
                wgpu::CompareFunction::Always,
                Default::default(),
            );
        Ok(Self {
            copy: gpu.pipeline(desc)?,
            constants: gpu.context.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("host depth"),
                size: size_of::<gpu_types::HostDepth>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            group: Mutex::default(),
        })
    }

    /// Uploads how the host's depth becomes that of a view.
    pub fn write(&self, context: &RenderContext, host: &HostView, view: &ViewData) {
        let clip_from_host = view.clip_from_view * host.clip_from_view.inverse();
        let row = |v: DVec4| v.as_vec4().to_array();
        let constants = gpu_types::HostDepth {
            numerator: row(clip_from_host.row(2)),
            denominator: row(clip_from_host.row(3)),
            rounding: rounding(host, view),
        };
        context
            .queue
            .write_buffer(&self.constants, 0, bytemuck::bytes_of(&constants));
    }

    /// Group 3, of the depth aspect of the host's depth; the last one if that is the same.
    pub fn bind(
        &self,
        context: &RenderContext,
        layouts: &BindGroupLayouts,
        depth: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        let mut kept = self.group.lock().unwrap_or_else(PoisonError::into_inner);
        let make = || {
            bind_in_order(
                &context.device,
                "host depth",
                &layouts.host,
                [
                    wgpu::BindingResource::TextureView(depth),
                    self.constants.as_entire_binding(),
                ],
            )
        };
        kept.get(depth.clone(), make).clone()
    }

    /// Records the copy, and the draws of the visible set over it.
    pub fn record(&self, frame: &mut Recording, host: &wgpu::BindGroup, batches: &[Batch]) {
        let mut pass = frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("host depth"),
            depth_stencil_attachment: Some(frame.canvas.targets.cleared()),
            timestamp_writes: frame.timings.pass("host depth"),
            ..Default::default()
        });
        frame.canvas.viewport.set(&mut pass);
        pass.set_bind_group(0, frame.view, &[]);
        pass.set_bind_group(3, host, &[]);
        pass.set_pipeline(&self.copy);
        pass.draw(0..3, 0..1);
        draw_batches(&mut pass, SurfacePass::HostSurface, batches, &frame.surfaces);
    }
}

/// What f32 loses of positions in the world, as part of their distance from its origin.
const WORLD_ROUNDING: f64 = 2.4e-7;

/// Relative difference of depths that is rounding: of matrices and positions in f32, by two renderers.
const ROUNDING: f64 = 1e-5;

/// What the depths of one surface may differ by: factors of 1, of our depth and of its square.
///
/// A shift by s of a surface at distance d changes a depth near / d by the part s / d, and a linear one by s over its
/// length.
fn rounding(host: &HostView, view: &ViewData) -> [f32; 4] {
    let far_away = WORLD_ROUNDING * view.eye.length();
    let factors = match view.depth {
        ViewDepth::Infinite { near } => [0.0, ROUNDING, far_away / near],
        ViewDepth::Finite { near, far } => {
            // Both depths are stored in f32 near 1, where a step of either is a part of its length.
            let host_length = host.clip_from_view.z_axis.z.abs().recip();
            let length = far - near;
            let step = f64::from(f32::EPSILON) * (length + host_length + near.abs());
            [(4.0 * step + far_away) / length, 0.0, 0.0]
        }
    };
    let [constant, share, square] = factors.map(|factor| factor as f32);
    [constant, share, square, 0.0]
}
