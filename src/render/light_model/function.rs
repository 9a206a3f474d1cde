//! Multiplies the mask of each light that has a shape or distances by the factor of its light model.
//!
//! Shader  `shaders/passes/light_model.wgsl`
//! Groups  0 view, 1 receiver, 2 light model; 3 barn map, for a light that has one
//! Reads   receiver depth.  Writes  the mask, multiplied, inside the light's scissor
//! Order   after the technique has left the mask, before `light_accumulate` of the same light
//!
//! One pass evaluates all parts of a light's model, so a light pays for one more draw however many it has.

use bevy_ecs::prelude::*;

use super::barn_maps::{BarnMapKey, BarnMaps};
use super::constants::model_constants;
use crate::render::frame::targets::MASK_FORMAT;
use crate::render::gpu::bind_groups::{bind_in_order, buffer_entry};
use crate::render::gpu::pipeline_cache::{EVERYWHERE, PipelineDesc, Stage};
use crate::render::gpu::strided::StridedUniforms;
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
    /// The pipeline of lights with a barn map, made with the first of them.
    mapped: Option<wgpu::RenderPipeline>,
    maps: BarnMaps,
    models: StridedUniforms<LightModel>,
    group: wgpu::BindGroup,
    /// The draw of each light, by index into [`FrameLights`]; `None` for lights that are not scaled.
    draws: Vec<Option<Draw>>,
}

/// One light of the frame that is scaled.
#[derive(Clone, Copy, Debug)]
struct Draw {
    /// Offset of the light's constants, bytes.
    offset: u32,
    /// The barn map, if the light has one.
    map: Option<BarnMapKey>,
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
        let models = StridedUniforms::new(&gpu.context, "light models");
        Ok(Self {
            pipeline: gpu.pipeline(describe(gpu, &layouts, None))?,
            mapped: None,
            maps: BarnMaps::new(gpu),
            group: bind(gpu, &layouts, &models),
            models,
            layouts,
            draws: Vec::new(),
        })
    }
}

/// The pipeline of lights with a barn map, whose layout is given, or without one.
fn describe(gpu: &Gpu, layouts: &Layouts, map: Option<&wgpu::BindGroupLayout>) -> PipelineDesc {
    let entry = if map.is_some() { "mapped" } else { "fragment" };
    let shared = &gpu.layouts;
    PipelineDesc::new(
        "light model",
        EVERYWHERE,
        Some(Stage::new("passes/light_model.wgsl", entry)),
    )
    .with_groups([
        Some(&shared.view),
        Some(&shared.receiver),
        Some(&layouts.model),
        map,
    ])
    .with_target(MASK_FORMAT, Some(MULTIPLY), wgpu::ColorWrites::ALL)
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
        self.draws.clear();
        self.models.constants.clear();
        let Some(view) = &world.resource::<View>().data else {
            return Ok(());
        };
        for light in world.resource::<FrameLights>().of_scene() {
            let is_drawn = is_scaled(light) && light.region.scissor.is_some();
            self.draws.push(is_drawn.then(|| {
                Draw {
                    offset: self.models.constants.push(&model_constants(light, view.eye)),
                    map: light
                        .model
                        .shape
                        .zip(light.model.barn_map)
                        .map(|(shape, map)| BarnMapKey { shape, map }),
                }
            }));
        }
        if self.models.write(input.context) {
            self.group = bind(input.gpu, &self.layouts, &self.models);
        }
        let mapped = self.draws.iter().flatten();
        let mapped = mapped.filter_map(|draw| Some((draw.map?, draw.offset)));
        if self.mapped.is_none() && mapped.clone().next().is_some() {
            let layout = Some(self.maps.layout());
            self.mapped = Some(input.gpu.pipeline(describe(input.gpu, &self.layouts, layout))?);
        }
        self.maps
            .require(input.gpu, mapped, (&self.layouts.model, &self.group))
    }

    fn scales(&self, light: usize) -> bool {
        self.draws.get(light).is_some_and(Option::is_some)
    }

    fn draw(&self, light: usize, pass: &mut wgpu::RenderPass, input: &ResolveInput) {
        let Some(draw) = self.draws.get(light).copied().flatten() else {
            return;
        };
        let map = draw.map.and_then(|key| self.maps.group(&key));
        match (map, &self.mapped) {
            (Some(map), Some(mapped)) => {
                pass.set_pipeline(mapped);
                pass.set_bind_group(3, map, &[]);
            }
            _ => pass.set_pipeline(&self.pipeline),
        }
        pass.set_bind_group(0, input.record.view, &[]);
        pass.set_bind_group(1, &input.masks.receiver_group, &[]);
        pass.set_bind_group(2, &self.group, &[draw.offset]);
        pass.draw(0..3, 0..1);
    }
}
