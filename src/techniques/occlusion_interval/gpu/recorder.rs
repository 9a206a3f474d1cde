//! Draws a light's receivers into the mask, with the visibility that the maps hold for the window of time.
//!
//! Shader  `shaders/techniques/occlusion_interval/resolve.wgsl`; twin `techniques::occlusion_interval::intervals`
//! Groups  0 view, 1 window and maps
//! Reads   depth.  Writes  the mask, inside the light's scissor
//! Order   before `light_accumulate` of the same light
//!
//! The mask is cleared to the share of the window in which the light shines at all, which is 1 unless the sun is below the
//! horizon: objects that are not in the maps show no shadow. If all receivers are in the maps, it may be cleared to 0
//! (`draws`).

use std::sync::Arc;

use bevy_ecs::prelude::*;

use super::draws::{Draws, LightPlan};
use super::gpu_maps::GpuMaps;
use super::gpu_types::Window;
use super::pipelines::{FILE, IntervalLayouts, Key, describe};
use crate::render::gpu::bind_groups::bind_in_order;
use crate::render::gpu::buffers::GrowingBuffer;
use crate::render::gpu::pipeline_cache::Variants;
use crate::render::gpu::strided::{Strided, StridedUniforms};
use crate::render::recorder::{Leaves, PrepareInput, RecordInput, Recorder, Resolve, ResolveInput};
use crate::render::{Gpu, RenderError};
use crate::techniques::occlusion_interval::component::OcclusionInterval;
use crate::techniques::occlusion_interval::scenes::IntervalScenes;
use crate::techniques::registry::Technique;
use crate::techniques::shared::texture_memory::TextureMemory;

/// The maps of a scene, bound with the buffer of all windows.
#[derive(Debug)]
struct BoundMaps {
    maps: GpuMaps,
    group: wgpu::BindGroup,
    is_used: bool,
}

/// The recorder of occlusion interval maps.
#[derive(Debug)]
pub struct IntervalNode {
    layouts: Arc<IntervalLayouts>,
    pipelines: Variants<Key>,
    maps: Vec<BoundMaps>,
    windows: StridedUniforms<Window>,
    instances: GrowingBuffer,
    draws: Draws,
}

impl IntervalNode {
    /// Compiles the shader. Pipelines and textures are made when a frame needs them.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        gpu.compile(&[FILE])?;
        let context = &gpu.context;
        Ok(Self {
            layouts: gpu.part(|gpu| IntervalLayouts::new(&gpu.context.device)),
            pipelines: Variants::default(),
            maps: Vec::new(),
            windows: StridedUniforms::new(context, "interval windows"),
            instances: GrowingBuffer::new(context, "interval instances", wgpu::BufferUsages::VERTEX),
            draws: Draws::default(),
        })
    }

    fn plan_of(&self, light: usize) -> Option<&LightPlan> {
        self.draws.lights.iter().find(|plan| plan.light == light)
    }

    fn bind(&self, input: &PrepareInput, maps: &GpuMaps) -> wgpu::BindGroup {
        bind_in_order(
            &input.context.device,
            "interval maps",
            &self.layouts.maps,
            [
                self.windows.binding(),
                wgpu::BindingResource::TextureView(&maps.view),
            ],
        )
    }

    /// The index of a scene's maps, which are uploaded if they are new. `None` if the device cannot hold them.
    fn upload(
        &mut self,
        world: &World,
        input: &PrepareInput,
        scenes: &IntervalScenes,
        light: usize,
    ) -> Option<usize> {
        let scene = scenes.scene_of(light)?;
        world
            .resource::<TextureMemory>()
            .grant(scene.payer?, OcclusionInterval::NAME)?;
        let known = self
            .maps
            .iter()
            .position(|bound| Arc::ptr_eq(&bound.maps.maps, &scene.maps));
        let index = match known {
            Some(index) => index,
            None => {
                let maps = GpuMaps::new(input.context, world, scene)?;
                let group = self.bind(input, &maps);
                self.maps.push(BoundMaps {
                    maps,
                    group,
                    is_used: true,
                });
                self.maps.len() - 1
            }
        };
        let bound = &mut self.maps[index];
        bound.is_used = true;
        if bound.maps.generation != scene.generation {
            bound.maps.refresh(input.context, world, scene);
        }
        Some(index)
    }
}

impl Recorder for IntervalNode {
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError> {
        self.draws.clear();
        self.windows.constants.clear();
        for bound in &mut self.maps {
            bound.is_used = false;
        }
        let scenes = world.resource::<IntervalScenes>();
        for light in &scenes.lights {
            let maps = self.upload(world, input, scenes, light.light);
            let window = maps.map(|at| {
                let maps = &self.maps[at].maps.maps;
                Window::new(&maps.window(light.time, light.width), maps.size, light.shining)
            });
            self.windows.constants.push(&window.unwrap_or_default());
            let bound = maps.map(|at| (at, &self.maps[at].maps));
            self.draws.plan_light(world, input, light, bound);
        }
        for &key in &self.draws.keys {
            let layouts = &self.layouts;
            input
                .gpu
                .require(&mut self.pipelines, key, |gpu| describe(gpu, layouts, key))?;
        }
        let is_windows_replaced = self.windows.write(input.context);
        if is_windows_replaced {
            for at in 0..self.maps.len() {
                self.maps[at].group = self.bind(input, &self.maps[at].maps);
            }
        }
        self.instances
            .write(input.context, bytemuck::cast_slice(&self.draws.objects));
        self.forget_unused();
        Ok(())
    }

    fn light(&self, light: usize) -> Option<Leaves<'_>> {
        self.plan_of(light).map(|_| Leaves::Mask(self))
    }

    /// Draws nothing: the maps have no geometry of their own.
    fn debug(&self, _light: usize, _pass: &mut wgpu::RenderPass, _input: &RecordInput) {}

    fn batch_count(&self, light: usize) -> usize {
        self.plan_of(light).map_or(0, |plan| plan.draws.len())
    }
}

impl IntervalNode {
    /// Frees maps that no light of the frame uses.
    fn forget_unused(&mut self) {
        if self.maps.iter().all(|bound| bound.is_used) {
            return;
        }
        let mut kept = 0;
        let moved: Vec<usize> = self
            .maps
            .iter()
            .map(|bound| {
                kept += usize::from(bound.is_used);
                kept.saturating_sub(1)
            })
            .collect();
        self.maps.retain(|bound| bound.is_used);
        for plan in &mut self.draws.lights {
            plan.maps = plan.maps.map(|at| moved[at]);
        }
    }
}

impl Resolve for IntervalNode {
    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        let Some(plan) = self.plan_of(light) else { return };
        let clear = f64::from(plan.clear);
        let everywhere = wgpu::Color {
            r: clear,
            g: clear,
            b: clear,
            a: clear,
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("interval lookup"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &input.masks.mask_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(everywhere),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &input.targets.depth_stencil_view,
                depth_ops: None,
                stencil_ops: None,
            }),
            timestamp_writes: input.timings.pass_of(input.label, "interval lookup"),
            ..Default::default()
        });
        let Some(bound) = plan.maps.and_then(|at| self.maps.get(at)) else {
            return;
        };
        input.record.viewport.set(&mut pass);
        let [x, y, width, height] = input.scissor;
        pass.set_scissor_rect(x, y, width, height);
        pass.set_bind_group(0, input.record.view, &[]);
        pass.set_bind_group(1, &bound.group, &[Strided::<Window>::offset(plan.window)]);
        pass.set_vertex_buffer(0, bound.maps.vertices.slice(..));
        pass.set_index_buffer(bound.maps.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.set_vertex_buffer(1, self.instances.buffer.slice(..));
        let mut last = None;
        for draw in &self.draws.draws[plan.draws.clone()] {
            if last != Some(draw.key) {
                let Some(pipeline) = self.pipelines.get(draw.key) else {
                    continue;
                };
                pass.set_pipeline(pipeline);
                last = Some(draw.key);
            }
            pass.draw_indexed(draw.indices.clone(), 0, draw.instance..draw.instance + 1);
        }
    }
}
