//! Leaves the visibility mask of one light: for every part of it the sums of hard shadow and coverage, then their share.
//!
//! Shader  `shaders/techniques/penumbra_wedge/{wedge,resolve}.wgsl`
//! Groups  0 view, 1 receiver, 2 wedges; the resolve also 3 sums
//! Reads   depth, planes of the receivers, the in-bounds bit.  Writes  sums, mask; with [`WedgeCulling::Stencil`] the stencil's count, left 0
//! Order   after the depth copy, before `light_accumulate` of the same light
//!
//! Faces behind the surface count, so the camera may stand in shadows and wedges; of casters that surely shadow no part
//! of the viewport it is the faces before the surface, which are fewer and need no caps.
//! Source: Assarsson et al. 2003, sections 4.2 to 4.4 and 5.

use bevy_ecs::prelude::*;

use super::buffers::SumTextures;
use super::form::Form;
use super::pipelines::{Key, Part, ResolveKey, WedgePipelines};
use super::plans::{CapDraw, LightPlan, PartPlan, counts_towards, light_record, passes};
use super::windows::{Shared, WedgeWindows};
use crate::render::gpu::bind_groups::{BindGroupLayouts, LIGHT_STRIDE, STORAGE, buffer_entry};
use crate::render::gpu::buffers::GrowingBuffer;
use crate::render::recorder::{Leaves, PrepareInput, RecordInput, Recorder, ResolveInput};
use crate::render::{RenderContext, RenderError, Shaders};
use crate::sets::{View, ViewData};
use crate::techniques::penumbra_wedge::component::MOST_IN_STEPS;
use crate::techniques::penumbra_wedge::component::{CoverageMaths, Overlap, VisibilityBuffer, WedgeCulling};
use crate::techniques::penumbra_wedge::geometry::records::{Wedge, WedgeCaster, WedgeLight};
use crate::techniques::penumbra_wedge::geometry::topology;
use crate::techniques::penumbra_wedge::geometry::topology::{HARD_SIDE, SHELLS};
use crate::techniques::penumbra_wedge::light_parts::PartShape;
use crate::techniques::penumbra_wedge::overflow::WedgeOverflow;
use crate::techniques::penumbra_wedge::tables::table_buffer::Tables;
use crate::techniques::penumbra_wedge::wedges::{Group, LightWedges, PenumbraWedges};

/// Name of the technique.
pub const NAME: &str = "penumbra_wedge";

/// The recorder.
#[derive(Debug)]
pub struct PenumbraWedgeNode {
    pub(in crate::techniques::penumbra_wedge) pipelines: WedgePipelines,
    pub(in crate::techniques::penumbra_wedge) wedge_layout: wgpu::BindGroupLayout,
    pub(in crate::techniques::penumbra_wedge) textures: SumTextures,
    pub(in crate::techniques::penumbra_wedge) indices: wgpu::Buffer,
    casters: GrowingBuffer,
    pub(in crate::techniques::penumbra_wedge) wedges: WedgeWindows,
    lights: GrowingBuffer,
    table_buffer: GrowingBuffer,
    pub(in crate::techniques::penumbra_wedge) tables: Tables,
    pub(in crate::techniques::penumbra_wedge) caps: GrowingBuffer,
    pub(in crate::techniques::penumbra_wedge) generation: u64,
    casters_generation: u64,
    pub(in crate::techniques::penumbra_wedge) light_records: Vec<WedgeLight>,
    light_bytes: Vec<u8>,
    pub(in crate::techniques::penumbra_wedge) plans: Vec<LightPlan>,
    pub(in crate::techniques::penumbra_wedge) parts: Vec<PartPlan>,
    pub(in crate::techniques::penumbra_wedge) groups: Vec<Group>,
    pub(in crate::techniques::penumbra_wedge) cap_draws: Vec<CapDraw>,
    pub(in crate::techniques::penumbra_wedge) mirrored: bool,
    pub(in crate::techniques::penumbra_wedge) blends_floats: bool,
}

impl PenumbraWedgeNode {
    /// Compiles the shaders; pipelines and textures come when a frame needs them.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(
        context: &RenderContext,
        shaders: &Shaders,
        layouts: &BindGroupLayouts,
    ) -> Result<Self, RenderError> {
        let device = &context.device;
        let vertex = wgpu::ShaderStages::VERTEX;
        let wedge_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("wedges"),
            entries: &[
                buffer_entry(0, vertex, STORAGE, false, size_of::<WedgeCaster>()),
                buffer_entry(1, vertex, STORAGE, false, size_of::<Wedge>()),
                buffer_entry(
                    2,
                    wgpu::ShaderStages::VERTEX_FRAGMENT,
                    wgpu::BufferBindingType::Uniform,
                    true,
                    size_of::<WedgeLight>(),
                ),
                buffer_entry(3, wgpu::ShaderStages::FRAGMENT, STORAGE, false, 16),
            ],
        });
        let storage = |label| GrowingBuffer::new(context, label, wgpu::BufferUsages::STORAGE);
        let mut indices = GrowingBuffer::new(context, "wedge triangles", wgpu::BufferUsages::INDEX);
        indices.write(context, bytemuck::cast_slice(&topology::indices()));
        let (casters, lights) = (
            storage("wedge casters"),
            GrowingBuffer::new(context, "wedge lights", wgpu::BufferUsages::UNIFORM),
        );
        let tables = storage("coverage tables");
        let textures = SumTextures::new(context);
        Ok(Self {
            pipelines: WedgePipelines::new(context, shaders, layouts, &wedge_layout, textures.layout())?,
            wedges: WedgeWindows::new(context, &wedge_layout, shared(&casters, &lights, &tables)),
            wedge_layout,
            textures,
            indices: indices.buffer,
            casters,
            lights,
            table_buffer: tables,
            tables: Tables::new(),
            caps: GrowingBuffer::new(context, "wedge caps", wgpu::BufferUsages::INDEX),
            generation: 0,
            casters_generation: 0,
            light_records: Vec::new(),
            light_bytes: Vec::new(),
            plans: Vec::new(),
            parts: Vec::new(),
            groups: Vec::new(),
            cap_draws: Vec::new(),
            mirrored: false,
            blends_floats: device.features().contains(wgpu::Features::FLOAT32_BLENDABLE),
        })
    }

    pub(in crate::techniques::penumbra_wedge) fn plan_of(&self, light: usize) -> Option<&LightPlan> {
        let at = self.plans.binary_search_by_key(&light, |plan| plan.light).ok()?;
        Some(&self.plans[at])
    }

    /// Draw calls of the caps of a group.
    fn cap_draw_count(&self, group: &Group) -> usize {
        let draws = self.cap_draws[group.casters.clone()].iter();
        draws
            .filter(|draw| !draw.towards)
            .map(|draw| {
                let near = draw.caps.iter().filter(|caps| !caps.is_empty()).count();
                near * (1 + usize::from(draw.has_far))
            })
            .sum()
    }

    /// Textures need sums by colour, for which there are no bytes.
    fn form(&self, light: &LightWedges) -> Form {
        if light.texture.is_some() {
            return if self.blends_floats {
                Form::Color
            } else {
                Form::HalfColor
            };
        }
        match (light.settings.buffer, light.settings.overlap) {
            (VisibilityBuffer::Split8, _) => Form::Split8,
            (VisibilityBuffer::Half, _) => Form::Half,
            (VisibilityBuffer::Float, _) if !self.blends_floats => Form::Split8,
            (VisibilityBuffer::Float, Overlap::Sampled) => {
                match (light.is_layered, light.stacked > MOST_IN_STEPS) {
                    (true, false) => Form::SampledLayers,
                    (false, false) => Form::Sampled,
                    (true, true) => Form::DeepLayers,
                    (false, true) => Form::Deep,
                }
            }
            (VisibilityBuffer::Float, Overlap::Additive | Overlap::Paper) => Form::Float,
        }
    }

    /// Uploads what changed.
    fn upload(&mut self, context: &RenderContext, world: &PenumbraWedges, view: &ViewData) {
        self.light_records.clear();
        self.light_records
            .extend(world.parts.iter().map(|part| light_record(part, view)));
        let mut rebind = self.tables.place(world, &mut self.light_records)
            && self
                .table_buffer
                .write(context, bytemuck::cast_slice(self.tables.entries()));
        // A light at every stride.
        self.light_bytes.clear();
        for record in &self.light_records {
            self.light_bytes.extend_from_slice(bytemuck::bytes_of(record));
            let filled = self.light_bytes.len().next_multiple_of(LIGHT_STRIDE as usize);
            self.light_bytes.resize(filled, 0);
        }
        rebind |= self.lights.write(context, &self.light_bytes);
        if self.casters_generation != world.casters_generation {
            self.casters_generation = world.casters_generation;
            rebind |= self
                .casters
                .write(context, bytemuck::cast_slice(&world.caster_records));
        }
        if self.generation != world.generation {
            self.generation = world.generation;
            let shared = shared(&self.casters, &self.lights, &self.table_buffer);
            self.wedges
                .write(context, &self.wedge_layout, &world.wedges, shared);
            self.caps.write(context, bytemuck::cast_slice(&world.caps));
        }
        if rebind {
            let shared = shared(&self.casters, &self.lights, &self.table_buffer);
            self.wedges.rebind(context, &self.wedge_layout, shared);
        }
    }

    /// Pipelines that a light needs.
    fn require(&mut self, context: &RenderContext, plan: &LightPlan, debug: bool) {
        let mirrored = self.mirrored;
        let looks_up = plan.settings.maths == CoverageMaths::Tables;
        for part in &self.parts[plan.parts.clone()] {
            let mut require_turned = |part_of_wedge, towards, turned: bool| {
                let key = Key {
                    part: part_of_wedge,
                    form: plan.form,
                    is_sphere: part.is_sphere,
                    looks_up,
                    towards,
                    mirrored: mirrored != turned,
                };
                self.pipelines.require(context, key);
            };
            for (layers, turned) in (1..=3).flat_map(|layers| [(layers, false), (layers, true)]) {
                require_turned(Part::NearCap(layers), false, turned);
                require_turned(Part::FarCap(layers), false, turned);
            }
            let mut require = |part_of_wedge, towards| require_turned(part_of_wedge, towards, false);
            for kind in passes(plan.settings.culling, part.has_extent) {
                require(*kind, false);
                if counts_towards(*kind) {
                    require(*kind, true);
                }
            }
            if debug {
                require(Part::Show, false);
            }
        }
        let is_sphere = self.parts[plan.parts.clone()].iter().any(|part| part.is_sphere);
        let is_combined = plan.settings.overlap == Overlap::Paper;
        let mut require = |combines, is_combined| {
            let key = ResolveKey {
                form: plan.form,
                is_sphere,
                combines,
                is_combined,
            };
            self.pipelines.require_resolve(context, key);
        };
        require(false, is_combined);
        if is_combined {
            require(true, false);
        }
    }
}

fn shared<'a>(
    casters: &'a GrowingBuffer,
    lights: &'a GrowingBuffer,
    tables: &'a GrowingBuffer,
) -> Shared<'a> {
    Shared {
        casters,
        lights,
        tables,
    }
}

impl Recorder for PenumbraWedgeNode {
    fn name(&self) -> &'static str {
        NAME
    }

    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError> {
        self.plans.clear();
        self.parts.clear();
        self.groups.clear();
        self.cap_draws.clear();
        let (Some(wedges), Some(view)) = (
            world.get_resource::<PenumbraWedges>(),
            world.get_resource::<View>().and_then(|view| view.data.as_ref()),
        ) else {
            return Ok(());
        };
        if let (Some(count), Some(report)) = (
            self.textures.overflow().take(),
            world.get_resource::<WedgeOverflow>(),
        ) {
            report.set(count);
        }
        if wedges.lights.is_empty() {
            return Ok(());
        }
        // Wedges are drawn from as many bindings as they need; their casters from one.
        let limit = input.context.device.limits().max_storage_buffer_binding_size;
        let needed = size_of_val(&wedges.caster_records[..]) as u64;
        if needed > limit {
            return Err(RenderError::Limit {
                what: "casters of all wedges",
                needed,
                limit,
            });
        }
        self.mirrored = input.mirrored_view;
        self.upload(input.context, wedges, view);
        self.groups.extend_from_slice(&wedges.groups);
        self.cap_draws.extend(
            wedges
                .casters
                .iter()
                .zip(&wedges.caster_records)
                .map(|(caster, record)| CapDraw {
                    mesh: input.table.mesh[caster.object as usize],
                    caps: caster.caps.clone(),
                    has_far: record.light_local[3] != 0.0 || record.extrusion > 0.0,
                    towards: caster.towards,
                }),
        );
        for light in &wedges.lights {
            let first = self.parts.len();
            for (number, index) in light.parts.clone().enumerate() {
                let part = &wedges.parts[index];
                self.parts.push(PartPlan {
                    index: index as u32,
                    groups: part.groups.clone(),
                    share: self
                        .tables
                        .share(&part.part, light.texture.as_ref(), number, light.parts.len()),
                    has_extent: part.part.shape != PartShape::Point,
                    is_sphere: matches!(part.part.shape, PartShape::Sphere { .. }),
                });
            }
            let plan = LightPlan {
                light: light.light,
                settings: light.settings,
                form: self.form(light),
                parts: first..self.parts.len(),
            };
            self.textures
                .require(input.context, input.target_size, plan.form)?;
            self.require(input.context, &plan, input.debug_view);
            self.plans.push(plan);
        }
        Ok(())
    }

    fn reads_planes(&self) -> bool {
        true
    }

    fn visibility(&self, light: usize) -> Option<Leaves> {
        self.plan_of(light).map(|_| Leaves::Mask)
    }

    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        self.record_mask(light, encoder, input);
    }

    fn debug(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput) {
        let Some(plan) = self.plan_of(light) else {
            return;
        };
        pass.set_bind_group(0, input.view, &[]);
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
        for part in &self.parts[plan.parts.clone()] {
            let key = Key {
                part: Part::Show,
                form: plan.form,
                is_sphere: part.is_sphere,
                looks_up: plan.settings.maths == CoverageMaths::Tables,
                towards: false,
                mirrored: self.mirrored,
            };
            let Some(pipeline) = self.pipelines.get(key) else {
                continue;
            };
            pass.set_pipeline(pipeline);
            let indices = if part.has_extent { SHELLS } else { HARD_SIDE };
            for group in &self.groups[part.groups.clone()] {
                self.wedges
                    .draw(pass, part.light_offset(), indices.clone(), group.wedges());
            }
        }
    }

    fn batch_count(&self, light: usize) -> usize {
        let Some(plan) = self.plan_of(light) else {
            return 0;
        };
        let parts = self.parts[plan.parts.clone()].iter();
        parts
            .map(|part| {
                let groups = self.groups[part.groups.clone()].iter();
                let drawn: usize = groups
                    .map(|group| {
                        let faces = match (plan.settings.culling, part.has_extent) {
                            (_, false) => 1,
                            (WedgeCulling::Stencil, true) => 1 + 4 * group.wedges().len(),
                            (_, true) => 2,
                        };
                        let ways = [&group.towards, &group.away];
                        let ways = ways.iter().filter(|wedges| !wedges.is_empty()).count();
                        self.cap_draw_count(group) + faces * ways
                    })
                    .sum();
                drawn + 1
            })
            .sum()
    }
}
