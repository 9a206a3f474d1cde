//! Records the stencil pass of one light. It leaves the count 0 exactly where no volume covers the visible
//! surface.
//!
//! Shader  `shaders/techniques/stencil_volume/volume.wgsl`; twin [`extrude`](crate::techniques::shared::extrude)
//! Groups  0 view, 2 casters, 3 positions of the caster's mesh
//! Reads   depth, the in-bounds bit.  Writes  the stencil's count only: no colour, no depth
//! Order   after `light_begin`, before `light_accumulate` of the same light
//!
//! Depth-fail counts the faces that fail the depth test, front −1 and back +1. So it counts faces behind
//! the surface, and the camera may be inside a volume. Depth-pass counts the faces that pass, front +1 and
//! back −1. Both wrap, so order does not matter and casters of either kind mix. A face exactly on the surface
//! does not pass, so caps that coincide with the surface of an open caster count as behind it. Depth is
//! reversed, so far caps at infinity have depth 0, which is the clear value. They do not pass either, as they
//! must not.
//! Source: Everitt & Kilgard 2002, "Practical and Robust Stenciled Shadow Volumes";
//! McGuire 2004, GPU Gems ch. 9.

use std::sync::Arc;

use bevy_ecs::prelude::*;

use super::gpu_types::Caster;
use super::long_lived::{LongLived, bind};
use super::pipelines::{FILE, Key, Part, Purpose, describe};
use super::quads::{CORNERS, QuadIndices};
use super::rounds::Rounds;
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::gpu::buffers::GrowingBuffer;
use crate::render::gpu::pipeline_cache::Variants;
use crate::render::recorder::{Leaves, Mark, PrepareInput, RecordInput, Recorder};
use crate::render::{Gpu, RenderError};
use crate::silhouettes::{LightSilhouettes, Silhouettes};
use crate::techniques::shared::gpu::contour_pool::{ContourPool, PooledContour};
use crate::techniques::stencil_volume::caster_volume::CasterVolume;
use crate::techniques::stencil_volume::component::MOST_STACKED;
use crate::techniques::stencil_volume::volumes::StencilVolumes;

/// One draw call. Materials do not split it, and casters of one mesh with equal silhouettes share it.
/// Source: O'Rorke 2004, GPU Gems ch. 15, §15.2.2, for batches of shadows apart from those of surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Draw {
    /// The round of counting of its light in which it is drawn.
    round: u32,
    key: Key,
    mesh: u32,
    /// True if light and far ends are at infinity, where the far ends of a side are one point.
    is_directional: bool,
    /// Index of the first cap index in the pool; 0 for sides.
    first: u32,
    /// The number of cap indices, or of sides.
    count: u32,
    /// Index of the first caster.
    caster: u32,
    caster_count: u32,
}

#[derive(Debug)]
struct LightDraws {
    light: usize,
    draws: std::ops::Range<usize>,
}

/// The inputs of the draws and of the casters' records. While they are the same, both are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Source {
    /// The [`StencilVolumes::revision`], which changes with the silhouettes and the places of its lights and casters.
    volumes: u64,
    /// The generation of the table of objects.
    table: u64,
    mirrored_view: bool,
}

/// The recorder of stencil volumes.
#[derive(Debug)]
pub struct StencilVolumeNode {
    pipelines: Variants<(Key, Purpose)>,
    rounds: Rounds,
    long_lived: Arc<LongLived>,
    pool: ContourPool,
    casters: GrowingBuffer,
    group: wgpu::BindGroup,
    caster_constants: Vec<Caster>,
    draws: Vec<Draw>,
    lights: Vec<LightDraws>,
    order: Vec<(Likeness, usize)>,
    /// `None` if there are no draws, or if preparing them failed.
    made_from: Option<Source>,
}

/// The key of casters with one silhouette: the mesh, the light in the caster's space bit for bit, and the cap
/// mode. Casters with equal keys have equal silhouettes.
type Likeness = (u32, [u32; 4], u32);

impl StencilVolumeNode {
    /// Compiles the shader. Pipelines are made when a frame needs them.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        gpu.compile(&[FILE])?;
        let context = &gpu.context;
        let long_lived = gpu.part(LongLived::new);
        let casters = GrowingBuffer::new(context, "volume casters", wgpu::BufferUsages::STORAGE);
        let pool = ContourPool::new(context);
        Ok(Self {
            pipelines: Variants::default(),
            rounds: Rounds::new(gpu)?,
            group: bind(context, &long_lived.casters, &casters.buffer, pool.edges()),
            long_lived,
            pool,
            casters,
            caster_constants: Vec::new(),
            draws: Vec::new(),
            lights: Vec::new(),
            order: Vec::new(),
            made_from: None,
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
                let Some(pipeline) = self.pipelines.get((draw.key, purpose)) else {
                    continue;
                };
                pass.set_pipeline(pipeline);
                last_key = Some(draw.key);
            }
            let caster = draw.caster..draw.caster + draw.caster_count;
            let matters = |caster: &Caster| match input.casters {
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
            // Caps get this group too, although they do not read it, because all parts share a layout.
            pass.set_bind_group(3, &mesh.positions_group, &[]);
            let is_quads = draw.key.part == Part::Side && !draw.is_directional;
            if has_quads != is_quads {
                has_quads = is_quads;
                if is_quads {
                    self.long_lived.quads.set(pass);
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

    fn clear(&mut self) {
        self.draws.clear();
        self.lights.clear();
        self.caster_constants.clear();
    }

    /// Makes the draws of all lights, and uploads the records of their casters. `replaced` tells that the pool has new
    /// buffers.
    fn make_draws(
        &mut self,
        volumes: &StencilVolumes,
        silhouettes: &Silhouettes,
        input: &PrepareInput,
        replaced: bool,
    ) {
        self.clear();
        for light in &volumes.lights {
            let first = self.draws.len();
            if let Some(known) = silhouettes.of_light(light.entity) {
                self.push_light(&light.casters, known, input);
            }
            self.lights.push(LightDraws {
                light: light.light,
                draws: first..self.draws.len(),
            });
        }
        let records: &[u8] = bytemuck::cast_slice(&self.caster_constants);
        if self.casters.write(input.context, records) || replaced {
            let (layout, edges) = (&self.long_lived.casters, self.pool.edges());
            self.group = bind(input.context, layout, &self.casters.buffer, edges);
        }
    }

    /// Appends the draws of a light's casters. Casters with equal silhouettes become adjacent.
    fn push_light(&mut self, volumes: &[CasterVolume], known: &LightSilhouettes, input: &PrepareInput) {
        let mut order = std::mem::take(&mut self.order);
        order.clear();
        order.extend(volumes.iter().enumerate().map(|(at, volume)| {
            let mesh = input.table.mesh[volume.object as usize];
            let mode = known.slots[volume.slot as usize].mode as u32;
            ((mesh, volume.light_local.to_array().map(f32::to_bits), mode), at)
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
            // Within one round no count may wrap around to 0.
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

    /// Joins consecutive draws that differ only in their casters.
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
        let corners_per_edge = volume.corners_per_edge();
        let is_directional = corners_per_edge < CORNERS;
        let caster = self.caster_constants.len() as u32;
        self.caster_constants.push(Caster {
            light_local: volume.light_local.to_array(),
            object: volume.object,
            extrusion: volume.extrusion,
            corners_per_edge,
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
        push(
            Part::Side,
            mirrored,
            0,
            pooled.single_count + 2 * pooled.double_count,
        );
        let away = pooled.first_cap + pooled.caps_away_start;
        let away_count = pooled.cap_count - pooled.caps_away_start;
        if volume.near_cap {
            push(Part::NearCap, mirrored, pooled.first_cap, pooled.caps_away_start);
            push(Part::NearCap, !mirrored, away, away_count);
        }
        if volume.far_cap {
            // The far cap has the near cap's triangles, seen from the other side.
            push(Part::FarCap, !mirrored, pooled.first_cap, pooled.caps_away_start);
            push(Part::FarCap, mirrored, away, away_count);
        }
    }
}

impl Mark for StencilVolumeNode {
    fn mark(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput) {
        self.record(self.draws_of(light), Purpose::Count, pass, input);
    }
}

impl Recorder for StencilVolumeNode {
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError> {
        let last = self.made_from.take();
        let (Some(volumes), Some(silhouettes)) = (
            world.get_resource::<StencilVolumes>(),
            world.get_resource::<Silhouettes>(),
        ) else {
            self.clear();
            return Ok(());
        };
        let replaced = self.pool.update(input.context, silhouettes);
        let replaced = replaced.inspect_err(|_| self.clear())?;
        let source = Source {
            volumes: volumes.revision,
            table: input.table.generation,
            mirrored_view: input.mirrored_view,
        };
        if replaced || last != Some(source) {
            self.make_draws(volumes, silhouettes, input, replaced);
        }
        let (gpu, layout) = (input.gpu, &self.long_lived.casters);
        let purposes: &[Purpose] = if input.debug_view {
            &[Purpose::Count, Purpose::Show]
        } else {
            &[Purpose::Count]
        };
        for alike in self.draws.chunk_by(|a, b| a.key == b.key) {
            let key = alike[0].key;
            for &purpose in purposes {
                let describe = |gpu: &Gpu| describe(gpu, layout, key, purpose);
                gpu.require(&mut self.pipelines, (key, purpose), describe)?;
            }
        }
        self.made_from = Some(source);
        Ok(())
    }

    fn light(&self, light: usize) -> Option<Leaves<'_>> {
        let own = self.lights.binary_search_by_key(&light, |entry| entry.light);
        own.is_ok().then_some(Leaves::Stencil(self))
    }

    fn debug(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput) {
        self.record(self.draws_of(light), Purpose::Show, pass, input);
    }

    fn batch_count(&self, light: usize) -> usize {
        self.draws_of(light).len()
    }
}
