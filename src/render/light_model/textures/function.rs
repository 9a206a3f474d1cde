//! Multiplies the mask of each light that has a cookie or a profile by their factor.
//!
//! Shader  `shaders/passes/light_texture.wgsl`
//! Groups  0 view, 1 receiver, 2 light texture
//! Reads   receiver depth.  Writes  the mask, multiplied, inside the light's scissor
//! Order   after the technique has left the mask, before `light_accumulate` of the same light

use std::sync::Arc;

use bevy_ecs::prelude::*;

use super::constants::texture_constants;
use super::groups::LightTextureGroups;
use super::store::LightTextureStore;
use crate::render::frame::targets::MASK_FORMAT;
use crate::render::gpu::pipeline_cache::{EVERYWHERE, PipelineDesc, Stage, Variants};
use crate::render::gpu::strided::StridedUniforms;
use crate::render::light_function::{LightFunction, MULTIPLY};
use crate::render::pools::gpu_types::LightTexture;
use crate::render::recorder::{PrepareInput, ResolveInput};
use crate::render::{Gpu, RenderError};
use crate::scene::light_model::cookie::placing::Projection;
use crate::sets::{FrameLight, FrameLights, View};

/// All that tells two pipelines of this pass apart.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    /// Where the cookie lies; `None` without a cookie.
    projection: Option<Projection>,
    has_profile: bool,
}

impl Key {
    fn of(light: &FrameLight) -> Self {
        let textures = &light.textures;
        Self {
            projection: textures
                .cookie
                .as_ref()
                .map(|cookie| Projection::of(light.light.kind, &cookie.image)),
            has_profile: textures.profile.is_some(),
        }
    }

    fn describe(self, gpu: &Gpu, store: &LightTextureStore) -> PipelineDesc {
        let projection = match self.projection {
            None => 0.0,
            Some(Projection::Plane) => 1.0,
            Some(Projection::Around) => 2.0,
            Some(Projection::Parallel) => 3.0,
            Some(Projection::Cube) => 4.0,
        };
        let fragment = Stage::new("passes/light_texture.wgsl", "fragment");
        let shared = &gpu.layouts;
        PipelineDesc::new("light texture", EVERYWHERE, Some(fragment))
            .with_groups([Some(&shared.view), Some(&shared.receiver), Some(&store.layout)])
            .with_constants([
                ("PROJECTION", projection),
                ("HAS_PROFILE", f64::from(u8::from(self.has_profile))),
            ])
            .with_target(MASK_FORMAT, Some(MULTIPLY), wgpu::ColorWrites::ALL)
    }
}

/// One light of the frame that has textures.
#[derive(Clone, Copy, Debug)]
struct Draw {
    key: Key,
    /// Index of the bind group.
    group: usize,
    /// Offset of the constants, bytes.
    offset: u32,
}

/// The light function of cookies and profiles.
#[derive(Debug)]
pub struct LightTextureFunction {
    store: Arc<LightTextureStore>,
    pipelines: Variants<Key>,
    constants: StridedUniforms<LightTexture>,
    groups: LightTextureGroups,
    /// The draw of each light, by index into [`FrameLights`]; `None` for lights without textures.
    draws: Vec<Option<Draw>>,
}

impl LightTextureFunction {
    /// Makes the function of one view.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            store: gpu.part(LightTextureStore::new),
            pipelines: Variants::default(),
            constants: StridedUniforms::new(&gpu.context, "light textures"),
            groups: LightTextureGroups::default(),
            draws: Vec::new(),
        }
    }

    fn prepare_light(
        &mut self,
        light: &FrameLight,
        eye_world: glam::DVec3,
        gpu: &Gpu,
    ) -> Result<Draw, RenderError> {
        let key = Key::of(light);
        let store = &self.store;
        gpu.require(&mut self.pipelines, key, |gpu| key.describe(gpu, store))?;
        let binding = self.constants.binding();
        let group = self.groups.acquire(gpu, store, &light.textures, binding);
        let table = self.groups.profile(group).map(|profile| &profile.table);
        let constants = texture_constants(light, table, eye_world);
        let offset = self.constants.constants.push(&constants);
        Ok(Draw { key, group, offset })
    }
}

impl LightFunction for LightTextureFunction {
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError> {
        self.draws.clear();
        self.constants.constants.clear();
        self.groups.remove_dead();
        let Some(view) = &world.resource::<View>().data else {
            return Ok(());
        };
        let lights = world.resource::<FrameLights>().of_scene();
        for light in lights {
            let is_drawn = !light.textures.is_empty() && light.region.scissor.is_some();
            let draw = is_drawn.then(|| self.prepare_light(light, view.eye, input.gpu));
            self.draws.push(draw.transpose()?);
        }
        if self.constants.write(input.context) {
            self.groups.clear();
            for (draw, light) in self.draws.iter_mut().zip(lights) {
                if let Some(draw) = draw {
                    let binding = self.constants.binding();
                    draw.group = self
                        .groups
                        .acquire(input.gpu, &self.store, &light.textures, binding);
                }
            }
        }
        self.store.forget_unused();
        Ok(())
    }

    fn scales(&self, light: usize) -> bool {
        self.draws.get(light).is_some_and(Option::is_some)
    }

    fn draw(&self, light: usize, pass: &mut wgpu::RenderPass, input: &ResolveInput) {
        let Some(draw) = self.draws.get(light).copied().flatten() else {
            return;
        };
        let (Some(pipeline), Some(group)) = (self.pipelines.get(draw.key), self.groups.get(draw.group))
        else {
            return;
        };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, input.record.view, &[]);
        pass.set_bind_group(1, &input.masks.receiver_group, &[]);
        pass.set_bind_group(2, group, &[draw.offset]);
        pass.draw(0..3, 0..1);
    }
}
