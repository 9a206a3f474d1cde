//! Multiplies the mask of each light that has a shape or distances by the factor of its light model.
//!
//! Shader  `shaders/passes/light_model.wgsl`
//! Groups  0 view, 1 receiver, 2 light model
//! Reads   receiver depth.  Writes  the mask, multiplied, inside the light's scissor
//! Order   after the technique has left the mask, before `light_accumulate` of the same light
//!
//! One pass evaluates all parts of a light's model, so a light pays for one more draw however many it has.

use bevy_ecs::prelude::*;

use super::constants::shape_constants;
use crate::render::frame::targets::MASK_FORMAT;
use crate::render::gpu::bind_groups::{bind_in_order, buffer_entry};
use crate::render::gpu::pipeline_cache::{EVERYWHERE, PipelineDesc, Stage};
use crate::render::gpu::strided::{Strided, StridedUniforms};
use crate::render::light_function::{LightFunction, MULTIPLY};
use crate::render::pools::gpu_types::LightModel;
use crate::render::recorder::{PrepareInput, ResolveInput};
use crate::render::{Gpu, RenderError};
use crate::sets::{FrameLight, FrameLights, View};

/// The layouts of the light model, which all views share.
#[derive(Debug)]
struct Layouts {
    /// The layout of group 2: the model of one light, at a dynamic offset.
    model: wgpu::BindGroupLayout,
}

impl Layouts {
    fn new(gpu: &Gpu) -> Self {
        let uniform = wgpu::BufferBindingType::Uniform;
        let stage = wgpu::ShaderStages::FRAGMENT;
        Self {
            model: gpu
                .context
                .device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: Some("light model"),
                    entries: &[buffer_entry(0, stage, uniform, true, size_of::<LightModel>())],
                }),
        }
    }
}

/// The light function of the light model.
#[derive(Debug)]
pub struct LightModelFunction {
    layouts: std::sync::Arc<Layouts>,
    pipeline: wgpu::RenderPipeline,
    models: StridedUniforms<LightModel>,
    group: wgpu::BindGroup,
    /// The index of each light's constants, by index into [`FrameLights`]; `None` for lights that are not scaled.
    slots: Vec<Option<usize>>,
}

/// Returns whether the light model scales what a light gives.
pub fn is_scaled(light: &FrameLight) -> bool {
    light.model.is_shaped()
}

impl LightModelFunction {
    /// Makes the function of one view.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let layouts = gpu.part(Layouts::new);
        let fragment = Stage::new("passes/light_model.wgsl", "fragment");
        let shared = &gpu.layouts;
        let desc = PipelineDesc::new("light model", EVERYWHERE, Some(fragment))
            .with_groups([Some(&shared.view), Some(&shared.receiver), Some(&layouts.model)])
            .with_target(MASK_FORMAT, Some(MULTIPLY), wgpu::ColorWrites::ALL);
        let models = StridedUniforms::new(&gpu.context, "light models");
        Ok(Self {
            pipeline: gpu.pipeline(desc)?,
            group: bind(gpu, &layouts, &models),
            models,
            layouts,
            slots: Vec::new(),
        })
    }
}

fn bind(gpu: &Gpu, layouts: &Layouts, models: &StridedUniforms<LightModel>) -> wgpu::BindGroup {
    bind_in_order(
        &gpu.context.device,
        "light models",
        &layouts.model,
        [models.binding()],
    )
}

impl LightFunction for LightModelFunction {
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError> {
        self.slots.clear();
        self.models.constants.clear();
        let Some(view) = &world.resource::<View>().data else {
            return Ok(());
        };
        let mut count = 0;
        for light in &world.resource::<FrameLights>().lights {
            let draws = is_scaled(light) && light.region.scissor.is_some();
            self.slots.push(draws.then_some(count));
            if draws {
                count += 1;
                self.models.constants.push(&LightModel {
                    shape: shape_constants(light, view.eye),
                });
            }
        }
        if self.models.write(input.context) {
            self.group = bind(input.gpu, &self.layouts, &self.models);
        }
        Ok(())
    }

    fn scales(&self, light: usize) -> bool {
        self.slots.get(light).is_some_and(Option::is_some)
    }

    fn draw(&self, light: usize, pass: &mut wgpu::RenderPass, input: &ResolveInput) {
        let Some(slot) = self.slots.get(light).copied().flatten() else {
            return;
        };
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, input.record.view, &[]);
        pass.set_bind_group(1, &input.masks.receiver_group, &[]);
        pass.set_bind_group(2, &self.group, &[Strided::<LightModel>::offset(slot)]);
        pass.draw(0..3, 0..1);
    }
}
