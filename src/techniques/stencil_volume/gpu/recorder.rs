//! Stencil pass of one light: leaves the count 0 exactly where no volume covers the visible surface.
//!
//! Shader  `shaders/techniques/stencil_volume/volume.wgsl`; twin [`extrude`](crate::techniques::shared::extrude)
//! Groups  0 view, 2 casters, 3 positions of the caster's mesh
//! Reads   depth, the in-bounds bit.  Writes  the stencil's count only: no colour, no depth
//! Order   after `light_begin`, before `light_accumulate` of the same light
//!
//! Depth-fail: faces that do not pass the depth test count, front −1, back +1; so what lies behind the surface is
//! counted, and the camera may be inside a volume. Depth-pass: faces that pass count, front +1, back −1. Both wrap, so
//! order is free, and casters of either kind mix. A face exactly on the surface does not pass: caps that coincide with
//! the surface of an open caster count as behind it. Depth is reversed: far caps at infinity land on 0, the clear value,
//! and do not pass either, as they must.
//! Source: Everitt & Kilgard 2002, "Practical and Robust Stenciled Shadow Volumes"; McGuire 2004, GPU Gems ch. 9.

use bevy_ecs::prelude::*;

use super::pipelines::{Key, Part, Purpose, VolumePipelines};
use super::quads::{CORNERS, QuadIndices};
use super::rounds::Rounds;
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::gpu::bind_groups::{BindGroupLayouts, STORAGE, bind_in_order, buffer_entry};
use crate::render::gpu::buffers::GrowingBuffer;
use crate::render::pools::gpu_types;
use crate::render::recorder::{Leaves, PrepareInput, RecordInput, Recorder};
use crate::render::{RenderContext, RenderError, Shaders};
use crate::sets::FrameLights;
use crate::silhouettes::{CapMode, LightSilhouettes, Silhouettes};
use crate::techniques::shared::extrude::TO_INFINITY;
use crate::techniques::shared::gpu::contour_pool::{ContourPool, PooledContour};
use crate::techniques::stencil_volume::component::MOST_STACKED;
use crate::techniques::stencil_volume::volumes::{CasterVolume, StencilVolumes};

/// Name of the technique.
pub const NAME: &str = "stencil_volume";

/// One draw call: materials do not split it, and casters of one mesh that see the light alike share it.
/// Source: O'Rorke 2004, GPU Gems ch. 15, §15.2.2, for batches of shadows apart from those of surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Draw {
    /// Which of the light's rounds of counting it belongs to.
    round: u32,
    key: Key,
    mesh: u32,
    /// Light and far ends are at infinity, and so the far ends of a side are one point.
    is_directional: bool,
    /// First index of a cap in the pool; 0 for sides.
    first: u32,
    /// Indices of a cap, or sides.
    count: u32,
    /// First of the casters.
    caster: u32,
    caster_count: u32,
}

#[derive(Debug)]
struct LightDraws {
    light: usize,
    draws: std::ops::Range<usize>,
}

/// The recorder.
#[derive(Debug)]
pub struct StencilVolumeNode {
    pipelines: VolumePipelines,
    rounds: Rounds,
    group_layout: wgpu::BindGroupLayout,
    pool: ContourPool,
    casters: GrowingBuffer,
    quads: QuadIndices,
    group: wgpu::BindGroup,
    caster_constants: Vec<gpu_types::Caster>,
    draws: Vec<Draw>,
    lights: Vec<LightDraws>,
    order: Vec<(Likeness, usize)>,
}

/// Casters alike in this have the same silhouette: the mesh, and the light in its space, bit for bit.
type Likeness = (u32, [u32; 4], bool);

impl StencilVolumeNode {
    /// Compiles the shader; pipelines come when a frame needs them.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(
        context: &RenderContext,
        shaders: &Shaders,
        layouts: &BindGroupLayouts,
    ) -> Result<Self, RenderError> {
        let group_layout = context
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("volume casters"),
                entries: &[
                    buffer_entry(
                        0,
                        wgpu::ShaderStages::VERTEX,
                        STORAGE,
                        false,
                        size_of::<gpu_types::Caster>(),
                    ),
                    buffer_entry(1, wgpu::ShaderStages::VERTEX, STORAGE, false, 8),
                ],
            });
        let casters = GrowingBuffer::new(context, "volume casters", wgpu::BufferUsages::STORAGE);
        let pool = ContourPool::new(context);
        Ok(Self {
            pipelines: VolumePipelines::new(context, shaders, layouts, &group_layout)?,
            rounds: Rounds::new(context, shaders)?,
            group: bind(context, &group_layout, &casters.buffer, pool.edges()),
            group_layout,
            pool,
            casters,
            quads: QuadIndices::new(context),
            caster_constants: Vec::new(),
            draws: Vec::new(),
            lights: Vec::new(),
            order: Vec::new(),
        })
    }

    fn draws_of(&self, light: usize) -> &[Draw] {
        match self.lights.binary_search_by_key(&light, |entry| entry.light) {
            Ok(at) => &self.draws[self.lights[at].draws.clone()],
            Err(_) => &[],
        }
    }

    fn record(&self, draws: &[Draw], purpose: Purpose, pass: &mut wgpu::RenderPass, input: &RecordInput) {
        pass.set_stencil_reference(STENCIL_IN_BOUNDS);
        pass.set_bind_group(0, input.view, &[]);
        pass.set_bind_group(2, &self.group, &[]);
        pass.set_index_buffer(self.pool.caps().slice(..), wgpu::IndexFormat::Uint32);
        let mut last_key = None;
        let mut has_quads = false;
        let mut round = 0;
        for draw in draws {
            if draw.round != round && purpose == Purpose::Count {
                round = draw.round;
                self.rounds.close(pass);
                last_key = None;
            }
            if last_key != Some(draw.key) {
                let Some(pipeline) = self.pipelines.get(draw.key, purpose) else {
                    continue;
                };
                pass.set_pipeline(pipeline);
                last_key = Some(draw.key);
            }
            let caster = draw.caster..draw.caster + draw.caster_count;
            let matters = |caster: &gpu_types::Caster| match input.casters {
                Some(casters) => casters.contains(caster.object as usize),
                None => true,
            };
            if !self.caster_constants[caster.start as usize..caster.end as usize]
                .iter()
                .any(matters)
            {
                continue;
            }
            let Some(mesh) = input.meshes.get(draw.mesh) else {
                continue;
            };
            // For caps too, which do not read it: all parts share a layout.
            pass.set_bind_group(3, &mesh.positions_group, &[]);
            let is_quads = draw.key.part == Part::Side && !draw.is_directional;
            if has_quads != is_quads {
                has_quads = is_quads;
                if is_quads {
                    self.quads.set(pass);
                } else {
                    pass.set_index_buffer(self.pool.caps().slice(..), wgpu::IndexFormat::Uint32);
                }
            }
            if is_quads {
                QuadIndices::draw(pass, draw.count, caster);
            } else if draw.key.part == Part::Side {
                pass.draw(0..3 * draw.count, caster);
            } else {
                pass.set_vertex_buffer(0, mesh.positions.slice(..));
                pass.draw_indexed(draw.first..draw.first + draw.count, 0, caster);
            }
        }
        if round > 0 {
            self.rounds.reopen(pass);
        }
    }

    /// Appends the draws of a light's casters, those with equal silhouettes one behind the other.
    fn push_light(&mut self, volumes: &[CasterVolume], known: &LightSilhouettes, input: &PrepareInput) {
        let mut order = std::mem::take(&mut self.order);
        order.clear();
        order.extend(volumes.iter().enumerate().map(|(at, volume)| {
            let mesh = input.table.mesh[volume.object as usize];
            let all = known.slots[volume.slot as usize].mode == CapMode::AllTriangles;
            ((mesh, volume.light_local.to_array().map(f32::to_bits), all), at)
        }));
        order.sort_unstable();
        let first = self.draws.len();
        let mut last: Option<(Likeness, PooledContour)> = None;
        let (mut round, mut counted) = (0, 0u32);
        for &(likeness, at) in &order {
            let volume = &volumes[at];
            let Some(own) = self.pool.get(known.light, volume.slot as usize) else {
                continue;
            };
            let pooled = match last {
                Some((like, pooled)) if like == likeness && pooled.is_like(&own) => pooled,
                _ => own,
            };
            last = Some((likeness, pooled));
            // Within one round no count comes round to 0.
            let stacked = known.slots[volume.slot as usize].stacked;
            if counted + stacked > MOST_STACKED && counted > 0 && known.stacked > MOST_STACKED {
                (round, counted) = (round + 1, 0);
            }
            counted += stacked;
            self.push_draws(volume, pooled, round, input);
        }
        self.order = order;
        self.draws[first..].sort_unstable();
        self.join_draws(first);
    }

    /// Makes one draw of those that differ in their casters alone, where these follow each other.
    fn join_draws(&mut self, first: usize) {
        let mut end = first;
        for at in first..self.draws.len() {
            let draw = self.draws[at];
            if end > first {
                let last = &mut self.draws[end - 1];
                let next = Draw {
                    caster: last.caster + last.caster_count,
                    ..draw
                };
                let same = (last.round, last.key, last.mesh, last.first, last.count);
                if draw == next && same == (draw.round, draw.key, draw.mesh, draw.first, draw.count) {
                    last.caster_count += draw.caster_count;
                    continue;
                }
            }
            self.draws[end] = draw;
            end += 1;
        }
        self.draws.truncate(end);
    }

    /// Appends the draws of one caster.
    fn push_draws(&mut self, volume: &CasterVolume, pooled: PooledContour, round: u32, input: &PrepareInput) {
        let object = volume.object as usize;
        let mirrored = (input.table.handedness[object] < 0.0) != input.mirrored_view;
        let is_directional = volume.light_local.w == 0.0 && volume.extrusion == TO_INFINITY;
        let caster = self.caster_constants.len() as u32;
        self.caster_constants.push(gpu_types::Caster {
            light_local: volume.light_local.to_array(),
            object: volume.object,
            extrusion: volume.extrusion,
            corners_per_edge: if is_directional { 3 } else { CORNERS },
            first_edge: pooled.first_edge,
            single_count: pooled.single_count,
            ..Default::default()
        });
        let mesh = input.table.mesh[object];
        let mut push = |part, clockwise, first, count| {
            if count > 0 {
                self.draws.push(Draw {
                    round,
                    key: Key {
                        part,
                        depth_pass: volume.depth_pass,
                        clockwise,
                    },
                    mesh,
                    is_directional,
                    first,
                    count,
                    caster,
                    caster_count: 1,
                });
            }
        };
        if volume.sides {
            push(
                Part::Side,
                mirrored,
                0,
                pooled.single_count + 2 * pooled.double_count,
            );
        }
        let away = pooled.first_cap + pooled.caps_away_start;
        let away_count = pooled.cap_count - pooled.caps_away_start;
        if volume.near_cap {
            push(Part::NearCap, mirrored, pooled.first_cap, pooled.caps_away_start);
            push(Part::NearCap, !mirrored, away, away_count);
        }
        if volume.far_cap {
            // The same triangles seen from the other end.
            push(Part::FarCap, !mirrored, pooled.first_cap, pooled.caps_away_start);
            push(Part::FarCap, mirrored, away, away_count);
        }
    }
}

fn bind(
    context: &RenderContext,
    layout: &wgpu::BindGroupLayout,
    casters: &wgpu::Buffer,
    edges: &wgpu::Buffer,
) -> wgpu::BindGroup {
    bind_in_order(
        &context.device,
        "volume casters",
        layout,
        [casters.as_entire_binding(), edges.as_entire_binding()],
    )
}

impl Recorder for StencilVolumeNode {
    fn name(&self) -> &'static str {
        NAME
    }

    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError> {
        self.draws.clear();
        self.lights.clear();
        self.caster_constants.clear();
        let (Some(volumes), Some(silhouettes), Some(lights)) = (
            world.get_resource::<StencilVolumes>(),
            world.get_resource::<Silhouettes>(),
            world.get_resource::<FrameLights>(),
        ) else {
            return Ok(());
        };
        let mut rebind = self.pool.update(input.context, silhouettes)?;
        for light in &volumes.lights {
            let first = self.draws.len();
            if let Some(known) = silhouettes.of_light(lights.lights[light.light].entity) {
                self.push_light(&light.casters, known, input);
            }
            self.lights.push(LightDraws {
                light: light.light,
                draws: first..self.draws.len(),
            });
        }
        rebind |= self
            .casters
            .write(input.context, bytemuck::cast_slice(&self.caster_constants));
        if rebind {
            self.group = bind(
                input.context,
                &self.group_layout,
                &self.casters.buffer,
                self.pool.edges(),
            );
        }
        for draw in &self.draws {
            self.pipelines.require(input.context, draw.key, Purpose::Count);
            if input.debug_view {
                self.pipelines.require(input.context, draw.key, Purpose::Show);
            }
        }
        Ok(())
    }

    fn visibility(&self, light: usize) -> Option<Leaves> {
        self.lights
            .binary_search_by_key(&light, |entry| entry.light)
            .is_ok()
            .then_some(Leaves::Stencil)
    }

    fn mark(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput) {
        self.record(self.draws_of(light), Purpose::Count, pass, input);
    }

    fn debug(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput) {
        self.record(self.draws_of(light), Purpose::Show, pass, input);
    }

    fn batch_count(&self, light: usize) -> usize {
        self.draws_of(light).len()
    }
}
