//! Leaves the visibility mask of one light. It sums hard shadow and coverage for each part of the light,
//! weighted by the part's share.
//!
//! Shader  `shaders/techniques/penumbra_wedge/{wedge,resolve}.wgsl`
//! Groups  0 view, 1 receiver, 2 wedges; the resolve also 3 sums
//! Reads   depth, planes of the receivers, the in-bounds bit.  Writes  sums, mask; with
//!         [`WedgeCulling::Stencil`] the stencil's count, which is 0 again afterwards
//! Order   after the depth copy, before `light_accumulate` of the same light
//!
//! Faces behind the surface count, so the camera may be inside shadows and wedges. For casters that certainly
//! shadow no part of the viewport, the faces in front of the surface count instead. These are fewer and need
//! no caps.
//! Source: Assarsson et al. 2003, sections 4.2 to 4.4 and 5.

use std::sync::Arc;

use bevy_ecs::prelude::*;

use super::buffers::SumTextures;
use super::form::{Form, Sampled};
use super::pipelines::{FILES, Key, Part, ResolveKey};
use super::plans::{CapDraw, LightPlan, PartPlan};
use super::windows::{WedgeWindows, shared};
use crate::render::gpu::bind_groups::{STORAGE, buffer_entry};
use crate::render::gpu::buffers::GrowingBuffer;
use crate::render::gpu::pipeline_cache::Variants;
use crate::render::gpu::strided::StridedUniforms;
use crate::render::recorder::{Leaves, PrepareInput, RecordInput, Recorder, Resolve, ResolveInput};
use crate::render::{Gpu, RenderContext, RenderError};
use crate::sets::View;
use crate::techniques::penumbra_wedge::component::MOST_IN_STEPS;
use crate::techniques::penumbra_wedge::component::{CoverageMaths, Overlap, VisibilityBuffer, WedgeCulling};
use crate::techniques::penumbra_wedge::geometry::records::{Wedge, WedgeCaster, WedgeLight};
use crate::techniques::penumbra_wedge::geometry::topology;
use crate::techniques::penumbra_wedge::geometry::topology::{HARD_SIDE, SHELLS};
use crate::techniques::penumbra_wedge::light_parts::PartShape;
use crate::techniques::penumbra_wedge::overflow::{ReducedSums, WedgeOverflow};
use crate::techniques::penumbra_wedge::tables::table_buffer::Tables;
use crate::techniques::penumbra_wedge::wedges::{Group, LightWedges, PenumbraWedges};

/// The parts of the recorder that all views of a device share.
#[derive(Debug)]
pub(in crate::techniques::penumbra_wedge) struct LongLived {
    /// The layout of group 2.
    pub(in crate::techniques::penumbra_wedge) wedge_layout: wgpu::BindGroupLayout,
    /// The triangles of one wedge.
    pub(in crate::techniques::penumbra_wedge) indices: wgpu::Buffer,
}

impl LongLived {
    fn new(gpu: &Gpu) -> Self {
        let vertex = wgpu::ShaderStages::VERTEX;
        let both = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let uniform = wgpu::BufferBindingType::Uniform;
        let entries = [
            buffer_entry(0, vertex, STORAGE, false, size_of::<WedgeCaster>()),
            buffer_entry(1, vertex, STORAGE, false, size_of::<Wedge>()),
            buffer_entry(2, both, uniform, true, size_of::<WedgeLight>()),
            buffer_entry(3, wgpu::ShaderStages::FRAGMENT, STORAGE, false, 16),
        ];
        let descriptor = wgpu::BindGroupLayoutDescriptor {
            label: Some("wedges"),
            entries: &entries,
        };
        let context = &gpu.context;
        let mut indices = GrowingBuffer::new(context, "wedge triangles", wgpu::BufferUsages::INDEX);
        indices.write(context, bytemuck::cast_slice(&topology::indices()));
        Self {
            wedge_layout: context.device.create_bind_group_layout(&descriptor),
            indices: indices.buffer,
        }
    }
}

/// The recorder of penumbra wedges.
#[derive(Debug)]
pub struct PenumbraWedgeNode {
    pub(in crate::techniques::penumbra_wedge) pipelines: Variants<Key>,
    pub(in crate::techniques::penumbra_wedge) resolves: Variants<ResolveKey>,
    pub(in crate::techniques::penumbra_wedge) long_lived: Arc<LongLived>,
    pub(in crate::techniques::penumbra_wedge) textures: SumTextures,
    pub(super) casters: GrowingBuffer,
    pub(in crate::techniques::penumbra_wedge) wedges: WedgeWindows,
    pub(super) lights: StridedUniforms<WedgeLight>,
    pub(super) table_buffer: GrowingBuffer,
    pub(in crate::techniques::penumbra_wedge) tables: Tables,
    pub(in crate::techniques::penumbra_wedge) caps: GrowingBuffer,
    pub(in crate::techniques::penumbra_wedge) generation: u64,
    pub(super) casters_generation: u64,
    pub(in crate::techniques::penumbra_wedge) light_records: Vec<WedgeLight>,
    pub(in crate::techniques::penumbra_wedge) plans: Vec<LightPlan>,
    pub(in crate::techniques::penumbra_wedge) parts: Vec<PartPlan>,
    pub(in crate::techniques::penumbra_wedge) groups: Vec<Group>,
    pub(in crate::techniques::penumbra_wedge) cap_draws: Vec<CapDraw>,
    pub(in crate::techniques::penumbra_wedge) mirrored: bool,
    pub(in crate::techniques::penumbra_wedge) blends_floats: bool,
    /// Whether a light of the last frame had sums in bytes, which may overflow.
    splits: bool,
    /// The device's limit on the bytes of a pixel in all targets of a pass.
    bytes_per_pixel: u32,
}

impl PenumbraWedgeNode {
    /// Compiles the shaders. Pipelines and textures are made when a frame needs them.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        gpu.compile(&FILES)?;
        let context = &gpu.context;
        let long_lived = gpu.part(LongLived::new);
        let storage = |label| GrowingBuffer::new(context, label, wgpu::BufferUsages::STORAGE);
        let casters = storage("wedge casters");
        let lights = StridedUniforms::new(context, "wedge lights");
        let tables = storage("coverage tables");
        let layout = &long_lived.wedge_layout;
        Ok(Self {
            pipelines: Variants::default(),
            resolves: Variants::default(),
            wedges: WedgeWindows::new(context, layout, shared(&casters, &lights, &tables)),
            textures: SumTextures::new(gpu),
            long_lived,
            casters,
            lights,
            table_buffer: tables,
            tables: Tables::new(),
            caps: GrowingBuffer::new(context, "wedge caps", wgpu::BufferUsages::INDEX),
            generation: 0,
            casters_generation: 0,
            light_records: Vec::new(),
            plans: Vec::new(),
            parts: Vec::new(),
            groups: Vec::new(),
            cap_draws: Vec::new(),
            mirrored: false,
            splits: false,
            blends_floats: context
                .device
                .features()
                .contains(wgpu::Features::FLOAT32_BLENDABLE),
            bytes_per_pixel: context.device.limits().max_color_attachment_bytes_per_sample,
        })
    }

    pub(in crate::techniques::penumbra_wedge) fn plan_of(&self, light: usize) -> Option<&LightPlan> {
        let at = self.plans.binary_search_by_key(&light, |plan| plan.light).ok()?;
        Some(&self.plans[at])
    }

    /// Returns the number of draw calls of a group's caps.
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

    /// Reports whether the device reduces sums, and the overflow that has arrived. Nothing can overflow once no light has sums in bytes, so counts that are
    /// still on their way are dropped then.
    fn report_overflow(&mut self, world: &World, context: &RenderContext, lights: &[LightWedges]) {
        if let Some(reduced) = world.get_resource::<ReducedSums>() {
            reduced.set(!self.blends_floats);
        }
        let splits = lights.iter().any(|light| self.form(light) == Form::Split8);
        let arrived = self.textures.overflow().take(context);
        let count = if splits { arrived } else { self.splits.then_some(0) };
        self.splits = splits;
        if let (Some(count), Some(report)) = (count, world.get_resource::<WedgeOverflow>()) {
            report.set(count);
        }
    }

    /// Returns the form of a light's sums. A textured light needs sums by colour, which have no form in
    /// bytes.
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
                let is_deep = light.stacked > MOST_IN_STEPS;
                Form::Sampled(Sampled::dense_if_allowed(
                    light.is_layered,
                    is_deep,
                    self.bytes_per_pixel,
                ))
            }
            (VisibilityBuffer::Float, Overlap::Additive | Overlap::Paper) => Form::Float,
        }
    }
}

impl Resolve for PenumbraWedgeNode {
    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        self.record_mask(light, encoder, input);
    }
}

impl Recorder for PenumbraWedgeNode {
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
        self.report_overflow(world, input.context, &wedges.lights);
        if wedges.lights.is_empty() {
            return Ok(());
        }
        // Wedges may use several bindings, but their casters must fit in one.
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
            self.require(input.gpu, &plan, input.debug_view)?;
            self.plans.push(plan);
        }
        Ok(())
    }

    fn light(&self, light: usize) -> Option<Leaves<'_>> {
        self.plan_of(light).map(|_| Leaves::Mask(self))
    }

    fn debug(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput) {
        let Some(plan) = self.plan_of(light) else {
            return;
        };
        pass.set_bind_group(0, input.view, &[]);
        pass.set_index_buffer(self.long_lived.indices.slice(..), wgpu::IndexFormat::Uint16);
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
