//! Leaves the visibility mask of one light: for every part of it the sums of hard shadow and coverage, then their share.
//!
//! Shader  `shaders/techniques/penumbra_wedge/{wedge,resolve}.wgsl`
//! Groups  0 view, 2 wedges, 3 receiver depth or sums
//! Reads   depth, the in-bounds bit.  Writes  sums, mask; with [`WedgeCulling::Stencil`] the stencil's count, left 0
//! Order   after the depth copy, before `light_accumulate` of the same light
//!
//! All counting is away from the viewer: faces behind the surface count, so the camera may stand in shadows and wedges.
//! Source: Assarsson et al. 2003, sections 4.2 to 4.4 and 5.

use std::ops::Range;
use std::sync::{Arc, Mutex};

use bevy_ecs::prelude::*;
use glam::{DMat4, Vec3};

use super::buffers::{SumTextures, Sums};
use super::component::{CoverageMaths, Overlap, PenumbraWedge, VisibilityBuffer, WedgeCulling};
use super::lookup::{self, LOOKUP_LENGTH};
use super::overflow::WedgeOverflow;
use super::parts::{LightPart, PartShape};
use super::records::{Wedge, WedgeCaster, WedgeLight};
use super::texture::{EmitterTexture, LightTexture, TABLE_LENGTH};
use super::topology::{self, HARD_SIDE, INNER_HALF, OUTER_HALF, SEPARATORS, SHELLS};
use super::wedge_pipelines::{Form, Key, Part, ResolveKey, WedgePipelines};
use super::wedges::{Group, LightWedges, PartWedges, PenumbraWedges};
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::bind_groups::{BindGroupLayouts, STORAGE, buffer_entry};
use crate::render::buffers::GrowingBuffer;
use crate::render::technique::{PrepareInput, RecordInput, ResolveInput, ShadowTechnique, Visibility};
use crate::render::{RenderContext, RenderError, Shaders};
use crate::sets::{View, ViewData, ViewportSize};

/// Name of the technique.
pub const NAME: &str = "penumbra_wedge";

/// The caps of one caster.
#[derive(Clone, Debug)]
struct CapDraw {
    mesh: u32,
    caps: [Range<u32>; 3],
    has_far: bool,
}

/// What is recorded for one part.
#[derive(Clone, Debug)]
struct PartPlan {
    groups: Range<usize>,
    /// Of the light, by colour and area.
    share: [f64; 4],
    has_extent: bool,
    is_sphere: bool,
}

#[derive(Clone, Debug)]
struct LightPlan {
    light: usize,
    settings: PenumbraWedge,
    form: Form,
    parts: Range<usize>,
}

/// Where the tables of all frames of a texture stand, for one part.
#[derive(Clone, Debug)]
struct PlacedTables {
    texture: Arc<LightTexture>,
    place: [f32; 4],
    first: u32,
    means: Vec<Vec3>,
}

/// The recorder.
#[derive(Debug)]
pub struct PenumbraWedgeNode {
    pipelines: WedgePipelines,
    wedge_layout: wgpu::BindGroupLayout,
    receiver_layout: wgpu::BindGroupLayout,
    receiver: Mutex<Option<(wgpu::TextureView, wgpu::BindGroup)>>,
    textures: SumTextures,
    indices: wgpu::Buffer,
    casters: GrowingBuffer,
    wedges: GrowingBuffer,
    lights: GrowingBuffer,
    tables: GrowingBuffer,
    table_entries: Vec<[f32; 4]>,
    lookup_is_new: bool,
    placed_tables: Vec<PlacedTables>,
    caps: GrowingBuffer,
    group: wgpu::BindGroup,
    generation: u64,
    light_records: Vec<WedgeLight>,
    plans: Vec<LightPlan>,
    parts: Vec<PartPlan>,
    groups: Vec<Group>,
    cap_draws: Vec<CapDraw>,
    mirrored: bool,
    blends_floats: bool,
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
                    STORAGE,
                    false,
                    size_of::<WedgeLight>(),
                ),
                buffer_entry(3, wgpu::ShaderStages::FRAGMENT, STORAGE, false, 16),
            ],
        });
        let receiver_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("receiver depth"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                count: None,
            }],
        });
        let storage = |label| GrowingBuffer::new(context, label, wgpu::BufferUsages::STORAGE);
        let mut indices = GrowingBuffer::new(context, "wedge triangles", wgpu::BufferUsages::INDEX);
        indices.write(context, bytemuck::cast_slice(&topology::indices()));
        let (casters, wedges, lights) = (
            storage("wedge casters"),
            storage("wedges"),
            storage("wedge lights"),
        );
        let tables = storage("coverage tables");
        let textures = SumTextures::new(context);
        Ok(Self {
            pipelines: WedgePipelines::new(
                context,
                shaders,
                layouts,
                &wedge_layout,
                &receiver_layout,
                textures.layout(),
            )?,
            group: bind(context, &wedge_layout, [&casters, &wedges, &lights, &tables]),
            wedge_layout,
            receiver_layout,
            receiver: Mutex::new(None),
            textures,
            indices: indices.buffer,
            casters,
            wedges,
            lights,
            tables,
            table_entries: lookup::entries(),
            lookup_is_new: true,
            placed_tables: Vec::new(),
            caps: GrowingBuffer::new(context, "wedge caps", wgpu::BufferUsages::INDEX),
            generation: 0,
            light_records: Vec::new(),
            plans: Vec::new(),
            parts: Vec::new(),
            groups: Vec::new(),
            cap_draws: Vec::new(),
            mirrored: false,
            blends_floats: device.features().contains(wgpu::Features::FLOAT32_BLENDABLE),
        })
    }

    fn plan_of(&self, light: usize) -> Option<&LightPlan> {
        let at = self.plans.binary_search_by_key(&light, |plan| plan.light).ok()?;
        Some(&self.plans[at])
    }

    /// Draw calls of the caps of a group.
    fn cap_draw_count(&self, group: &Group) -> usize {
        let draws = self.cap_draws[group.casters.clone()].iter();
        draws
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
        match light.settings.buffer {
            VisibilityBuffer::Float if self.blends_floats => Form::Float,
            VisibilityBuffer::Float | VisibilityBuffer::Split8 => Form::Split8,
        }
    }

    /// Uploads what changed.
    fn upload(&mut self, context: &RenderContext, world: &PenumbraWedges, view: &ViewData) {
        self.light_records.clear();
        self.light_records
            .extend(world.parts.iter().map(|part| light_record(part, view)));
        let mut rebind = self.place_tables(context, world);
        rebind |= self
            .lights
            .write(context, bytemuck::cast_slice(&self.light_records));
        if self.generation != world.generation {
            self.generation = world.generation;
            rebind |= self
                .casters
                .write(context, bytemuck::cast_slice(&world.caster_records));
            rebind |= self.wedges.write(context, bytemuck::cast_slice(&world.wedges));
            self.caps.write(context, bytemuck::cast_slice(&world.caps));
        }
        if rebind {
            let buffers = [&self.casters, &self.wedges, &self.lights, &self.tables];
            self.group = bind(context, &self.wedge_layout, buffers);
        }
    }

    /// Builds and uploads the tables of textures that are new, forgets those that are gone, and tells the lights where
    /// theirs stand; whether the buffer was exchanged.
    fn place_tables(&mut self, context: &RenderContext, world: &PenumbraWedges) -> bool {
        let needs = |tables: &PlacedTables| {
            world.lights.iter().any(|light| {
                let texture = light.texture.as_ref();
                texture.is_some_and(|texture| Arc::ptr_eq(&texture.texture, &tables.texture))
            })
        };
        let mut changed = std::mem::take(&mut self.lookup_is_new);
        if !self.placed_tables.iter().all(needs) {
            // Rare, and all that stay are rebuilt: places are given out in a row.
            self.placed_tables.clear();
            self.table_entries.truncate(LOOKUP_LENGTH);
        }
        for light in &world.lights {
            let Some(EmitterTexture { texture, frame }) = &light.texture else {
                continue;
            };
            for index in light.parts.clone() {
                let place = world.parts[index].part.place;
                let known = self
                    .placed_tables
                    .iter()
                    .position(|tables| Arc::ptr_eq(&tables.texture, texture) && tables.place == place);
                let at = known.unwrap_or_else(|| {
                    changed = true;
                    let first = self.table_entries.len() as u32;
                    let frames = (0..texture.frame_count()).map(|frame| texture.tables(frame, place));
                    let means = frames
                        .map(|tables| {
                            self.table_entries.extend(tables.entries);
                            tables.mean
                        })
                        .collect();
                    self.placed_tables.push(PlacedTables {
                        texture: texture.clone(),
                        place,
                        first,
                        means,
                    });
                    self.placed_tables.len() - 1
                });
                let frame = frame % texture.frame_count();
                self.light_records[index].table =
                    self.placed_tables[at].first + (frame * TABLE_LENGTH) as u32;
            }
        }
        changed
            && self
                .tables
                .write(context, bytemuck::cast_slice(&self.table_entries))
    }

    /// What a part gives to the mask where it is wholly seen: by colour, and of the area.
    fn share(&self, part: &LightPart, texture: Option<&EmitterTexture>, parts: usize) -> [f64; 4] {
        let share = (parts as f64).recip();
        let placed = texture.and_then(|texture| {
            let tables = self.placed_tables.iter();
            let mut tables = tables.filter(|tables| Arc::ptr_eq(&tables.texture, &texture.texture));
            let tables = tables.find(|tables| tables.place == part.place)?;
            Some(tables.means[texture.frame % tables.means.len()].as_dvec3() * share)
        });
        placed.map_or([share; 4], |color| color.extend(share).to_array())
    }

    /// Pipelines that a light needs.
    fn require(&mut self, context: &RenderContext, plan: &LightPlan, debug: bool) {
        let mirrored = self.mirrored;
        let looks_up = plan.settings.maths == CoverageMaths::Tables;
        for part in &self.parts[plan.parts.clone()] {
            let mut require = |part_of_wedge, is_sphere| {
                let key = Key {
                    part: part_of_wedge,
                    form: plan.form,
                    is_sphere,
                    looks_up,
                    mirrored,
                };
                self.pipelines.require(context, key);
            };
            for layers in 1..=3 {
                require(Part::NearCap(layers), false);
                require(Part::FarCap(layers), false);
            }
            for kind in passes(plan.settings.culling, part.has_extent) {
                require(*kind, part.is_sphere);
            }
            if debug {
                require(Part::Show, part.is_sphere);
            }
        }
        let combined = plan.settings.overlap == Overlap::Paper;
        for (combines, is_combined) in [(true, false), (false, combined)] {
            if combines && !combined {
                continue;
            }
            self.pipelines.require_resolve(
                context,
                ResolveKey {
                    form: plan.form,
                    combines,
                    is_combined,
                },
            );
        }
    }

    /// Group 3 of the wedges.
    fn receiver_group(&self, context: &wgpu::TextureView, device: &wgpu::Device) -> wgpu::BindGroup {
        let mut kept = self
            .receiver
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        match &*kept {
            Some((view, group)) if view == context => group.clone(),
            _ => {
                let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("receiver depth"),
                    layout: &self.receiver_layout,
                    entries: &[wgpu::BindGroupEntry {
                        binding: 0,
                        resource: wgpu::BindingResource::TextureView(context),
                    }],
                });
                *kept = Some((context.clone(), group.clone()));
                group
            }
        }
    }

    /// Draws one group into the sums; the pass has its scissor.
    fn record_group(
        &self,
        pass: &mut wgpu::RenderPass,
        plan: &LightPlan,
        part: &PartPlan,
        group: &Group,
        input: &RecordInput,
    ) {
        let pipeline = |kind| {
            self.pipelines.get(Key {
                part: kind,
                form: plan.form,
                is_sphere: part.is_sphere && !matches!(kind, Part::NearCap(_) | Part::FarCap(_)),
                looks_up: plan.settings.maths == CoverageMaths::Tables,
                mirrored: self.mirrored,
            })
        };
        pass.set_index_buffer(self.caps.buffer.slice(..), wgpu::IndexFormat::Uint32);
        for (layers, is_far) in (1..=3).flat_map(|layers| [(layers, false), (layers, true)]) {
            let kind = if is_far {
                Part::FarCap(layers)
            } else {
                Part::NearCap(layers)
            };
            let Some(pipeline) = pipeline(kind) else {
                continue;
            };
            pass.set_pipeline(pipeline);
            for (caster, draw) in group.casters.clone().zip(&self.cap_draws[group.casters.clone()]) {
                let Some(mesh) = input.meshes.get(draw.mesh) else {
                    continue;
                };
                let caps = &draw.caps[usize::from(layers) - 1];
                if caps.is_empty() || (is_far && !draw.has_far) {
                    continue;
                }
                pass.set_vertex_buffer(0, mesh.positions.slice(..));
                pass.draw_indexed(caps.clone(), 0, caster as u32..caster as u32 + 1);
            }
        }
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
        let draw = |pass: &mut wgpu::RenderPass, kind, indices: Range<u32>, wedges: Range<u32>| {
            if let Some(pipeline) = pipeline(kind) {
                pass.set_pipeline(pipeline);
                pass.draw_indexed(indices, 0, wedges);
            }
        };
        if !part.has_extent {
            draw(pass, Part::HardSide, HARD_SIDE, group.wedges.clone());
            return;
        }
        match plan.settings.culling {
            WedgeCulling::Depth => {
                draw(pass, Part::Separator, SEPARATORS, group.wedges.clone());
                draw(pass, Part::Shell, SHELLS, group.wedges.clone());
            }
            WedgeCulling::None => {
                draw(pass, Part::Separator, SEPARATORS, group.wedges.clone());
                draw(pass, Part::ShellEverywhere, SHELLS, group.wedges.clone());
            }
            WedgeCulling::Stencil => {
                draw(pass, Part::HardSide, HARD_SIDE, group.wedges.clone());
                for wedge in group.wedges.clone() {
                    for (half, kind) in [(OUTER_HALF, Part::OuterHalf), (INNER_HALF, Part::InnerHalf)] {
                        draw(pass, Part::Mark, half.clone(), wedge..wedge + 1);
                        draw(pass, kind, half, wedge..wedge + 1);
                    }
                }
            }
        }
    }

    fn record_sums(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        plan: &LightPlan,
        part: &PartPlan,
        sums: &Sums,
        group: Option<&Group>,
        receiver: &wgpu::BindGroup,
        input: &ResolveInput,
    ) {
        let attachments: smallvec::SmallVec<[_; 4]> = sums
            .views
            .iter()
            .map(|view| Some(attachment(view, wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT))))
            .collect();
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("wedges"),
            color_attachments: &attachments,
            depth_stencil_attachment: Some(depth_stencil(input)),
            timestamp_writes: timestamp(input, "wedges")
                .as_ref()
                .and_then(|label| input.timings.pass(label)),
            ..Default::default()
        });
        if let Some(group) = group {
            let [x, y, width, height] = input.scissor;
            pass.set_scissor_rect(x, y, width, height);
            pass.set_stencil_reference(STENCIL_IN_BOUNDS);
            pass.set_bind_group(0, input.record.view, &[]);
            pass.set_bind_group(2, &self.group, &[]);
            pass.set_bind_group(3, receiver, &[]);
            self.record_group(&mut pass, plan, part, group, &input.record);
        }
    }

    fn record_resolve(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        key: ResolveKey,
        target: wgpu::RenderPassColorAttachment,
        sums: &wgpu::BindGroup,
        share: [f64; 4],
        input: &ResolveInput,
    ) {
        let Some(pipeline) = self.pipelines.get_resolve(key) else {
            return;
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("wedge resolve"),
            color_attachments: &[Some(target)],
            timestamp_writes: timestamp(input, "resolve")
                .as_ref()
                .and_then(|label| input.timings.pass(label)),
            ..Default::default()
        });
        let [x, y, width, height] = input.scissor;
        let [r, g, b, a] = share;
        pass.set_scissor_rect(x, y, width, height);
        pass.set_pipeline(pipeline);
        pass.set_blend_constant(wgpu::Color { r, g, b, a });
        pass.set_bind_group(3, sums, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// `<label of the light>/<pass>`, if anybody looks at it.
fn timestamp(input: &ResolveInput, pass: &str) -> Option<String> {
    input
        .timings
        .is_active()
        .then(|| format!("{}/{pass}", input.label))
}

fn attachment(
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load,
            store: wgpu::StoreOp::Store,
        },
    }
}

fn depth_stencil<'a>(input: &ResolveInput<'a>) -> wgpu::RenderPassDepthStencilAttachment<'a> {
    wgpu::RenderPassDepthStencilAttachment {
        view: &input.targets.depth_stencil_view,
        depth_ops: None,
        stencil_ops: Some(wgpu::Operations {
            load: wgpu::LoadOp::Load,
            store: wgpu::StoreOp::Store,
        }),
    }
}

fn bind(
    context: &RenderContext,
    layout: &wgpu::BindGroupLayout,
    buffers: [&GrowingBuffer; 4],
) -> wgpu::BindGroup {
    let entry = |binding: u32| wgpu::BindGroupEntry {
        binding,
        resource: buffers[binding as usize].buffer.as_entire_binding(),
    };
    context.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("wedges"),
        layout,
        entries: &[entry(0), entry(1), entry(2), entry(3)],
    })
}

/// What the passes of a light draw.
fn passes(culling: WedgeCulling, has_extent: bool) -> &'static [Part] {
    use Part::{HardSide, InnerHalf, Mark, OuterHalf, Separator, Shell, ShellEverywhere};
    match (culling, has_extent) {
        (_, false) => &[HardSide],
        (WedgeCulling::Depth, true) => &[Separator, Shell],
        (WedgeCulling::None, true) => &[Separator, ShellEverywhere],
        (WedgeCulling::Stencil, true) => &[HardSide, Mark, OuterHalf, InnerHalf],
    }
}

/// The shader's view of one part.
fn light_record(part: &PartWedges, view: &ViewData) -> WedgeLight {
    let part = &part.part;
    let clip_from_light = view.clip_from_world * part.world_from_light;
    let light_from_relative = part.world_from_light.inverse() * DMat4::from_translation(view.eye);
    let rows = light_from_relative.transpose().as_mat4();
    let half_size = match part.shape {
        PartShape::Point => [0.0; 2],
        PartShape::Rect { half } => half.as_vec2().to_array(),
        PartShape::Sphere { radius } => [radius as f32; 2],
    };
    WedgeLight {
        clip_from_light: clip_from_light.as_mat4().to_cols_array_2d(),
        light_from_relative_x: rows.x_axis.to_array(),
        light_from_relative_y: rows.y_axis.to_array(),
        light_from_relative_z: rows.z_axis.to_array(),
        half_size,
        table: 0,
        padding: 0,
        place: part.place,
    }
}

impl ShadowTechnique for PenumbraWedgeNode {
    fn name(&self) -> &'static str {
        NAME
    }

    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError> {
        self.plans.clear();
        self.parts.clear();
        self.groups.clear();
        self.cap_draws.clear();
        let (Some(wedges), Some(view), Some(viewport)) = (
            world.get_resource::<PenumbraWedges>(),
            world.get_resource::<View>().and_then(|view| view.data.as_ref()),
            world.get_resource::<ViewportSize>(),
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
        self.mirrored = input.mirrored_view;
        let limit = input.context.device.limits().max_storage_buffer_binding_size;
        let needed = size_of_val(&wedges.wedges[..]) as u64;
        if needed > limit {
            return Err(RenderError::Limit {
                what: "wedges of all lights",
                needed,
                limit,
            });
        }
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
                    has_far: record.light_local[3] != 0.0,
                }),
        );
        for light in &wedges.lights {
            let first = self.parts.len();
            for part in &wedges.parts[light.parts.clone()] {
                self.parts.push(PartPlan {
                    groups: part.groups.clone(),
                    share: self.share(&part.part, light.texture.as_ref(), light.parts.len()),
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
            self.textures.require(input.context, viewport.0, plan.form)?;
            self.require(input.context, &plan, input.debug_view);
            self.plans.push(plan);
        }
        Ok(())
    }

    fn visibility(&self, light: usize) -> Option<Visibility> {
        self.plan_of(light).map(|_| Visibility::Mask)
    }

    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        let Some(plan) = self.plan_of(light) else {
            return;
        };
        let (Some(sums), Some(combined)) = (self.textures.get(plan.form), self.textures.combined()) else {
            return;
        };
        let receiver = self.receiver_group(&input.masks.receiver_depth_view, input.device);
        {
            let radiance = attachment(&input.targets.radiance_view, wgpu::LoadOp::Load);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("wedge bounds"),
                color_attachments: &[Some(radiance)],
                depth_stencil_attachment: Some(depth_stencil(input)),
                ..Default::default()
            });
            let [x, y, width, height] = input.scissor;
            pass.set_scissor_rect(x, y, width, height);
            let (near, far) = input.depth_range;
            input.light_begin.record(&mut pass, near, far);
        }
        let combines = plan.settings.overlap == Overlap::Paper;
        let mut load = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        for part in &self.parts[plan.parts.clone()] {
            let mut source = 0;
            if combines {
                let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
                encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("no coverage"),
                    color_attachments: &[Some(attachment(&combined[source], clear))],
                    ..Default::default()
                });
                for group in &self.groups[part.groups.clone()] {
                    self.record_sums(encoder, plan, part, sums, Some(group), &receiver, input);
                    let key = ResolveKey {
                        form: plan.form,
                        combines: true,
                        is_combined: false,
                    };
                    let target = attachment(&combined[1 - source], wgpu::LoadOp::Load);
                    self.record_resolve(encoder, key, target, &sums.groups[source], part.share, input);
                    source = 1 - source;
                }
            } else {
                let group = self.groups[part.groups.clone()].first();
                self.record_sums(encoder, plan, part, sums, group, &receiver, input);
            }
            let key = ResolveKey {
                form: plan.form,
                combines: false,
                is_combined: combines,
            };
            let target = attachment(&input.masks.mask_view, load);
            self.record_resolve(encoder, key, target, &sums.groups[source], part.share, input);
            load = wgpu::LoadOp::Load;
        }
        if plan.form == Form::Split8 {
            self.textures.overflow().record(encoder);
        }
    }

    fn debug(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput) {
        let Some(plan) = self.plan_of(light) else {
            return;
        };
        pass.set_bind_group(0, input.view, &[]);
        pass.set_bind_group(2, &self.group, &[]);
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
        for part in &self.parts[plan.parts.clone()] {
            let key = Key {
                part: Part::Show,
                form: plan.form,
                is_sphere: part.is_sphere,
                looks_up: plan.settings.maths == CoverageMaths::Tables,
                mirrored: self.mirrored,
            };
            let Some(pipeline) = self.pipelines.get(key) else {
                continue;
            };
            pass.set_pipeline(pipeline);
            let indices = if part.has_extent { SHELLS } else { HARD_SIDE };
            for group in &self.groups[part.groups.clone()] {
                pass.draw_indexed(indices.clone(), 0, group.wedges.clone());
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
                            (WedgeCulling::Stencil, true) => 1 + 4 * group.wedges.len(),
                            (_, true) => 2,
                        };
                        self.cap_draw_count(group) + faces
                    })
                    .sum();
                drawn + 1
            })
            .sum()
    }
}
