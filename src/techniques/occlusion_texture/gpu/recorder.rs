//! Draws and filters the slices of the lights whose casters changed, and looks them up into the mask.
//!
//! Shaders `shaders/techniques/occlusion_texture/{caster,filter,resolve}.wgsl`
//! Groups  casters: 0 casters, 1 face, 2 material; filter: 0 level below; lookup: 0 view, 1 receiver, 2 light, 3 pictures
//! Reads   receiver depth and plane.  Writes  the mask, inside the light's scissor
//! Order   after `depth copy` and `receiver plane`, before `light_accumulate` of the same light
//!
//! Pictures are drawn by `draw_pictures`, once a frame, before any pass on the screen.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use bevy_ecs::prelude::*;

use super::pipelines::{FILES, Key, SliceLayouts, describe};
use super::texture_pool::TexturePool;
use super::textures::TexturesKey;
use crate::render::gpu::bind_groups::bind_in_order;
use crate::render::gpu::buffers::GrowingBuffer;
use crate::render::gpu::pipeline_cache::Variants;
use crate::render::gpu::strided::StridedUniforms;
use crate::render::recorder::{
    Leaves, PictureInput, PrepareInput, RecordInput, Recorder, Resolve, ResolveInput,
};
use crate::render::{Gpu, RenderContext, RenderError};
use crate::sets::{FrameLights, Objects, View, ViewData};
use crate::techniques::maps::gpu::draws::MapDraws;
use crate::techniques::maps::gpu::recorded::Recorded;
use crate::techniques::occlusion_texture::build::OcclusionTextures;
use crate::techniques::occlusion_texture::light_slices::LightSlices;
use crate::techniques::occlusion_texture::records::{OcclusionFace, OcclusionLight};

/// The draws of one picture: casters by whether they close leaks, and by whether they are closed. Fronts and backs of casters
/// that are both are two sets.
#[derive(Debug)]
pub(super) struct FacePlan {
    pub draws: [SetPlan; 5],
    /// The draws of closed casters that pass through several slices, which fill the slices between their fronts and backs.
    pub filled: Range<usize>,
}

/// Draws that share their pipelines.
#[derive(Debug)]
pub(super) struct SetPlan {
    pub draws: Range<usize>,
    pub closes: bool,
    pub culled: Option<wgpu::Face>,
}

/// The passes and draws that one light needs.
#[derive(Debug)]
pub(super) struct LightPlan {
    /// Index of the light.
    pub light: usize,
    pub key: TexturesKey,
    pub lookup: Key,
    /// Pictures that are drawn again, as a range of [`SliceNode::faces`]; empty if they are up to date.
    pub faces: Range<usize>,
    /// Levels of N-buffers that are built.
    pub levels: u32,
    pub revision: u64,
}

/// The recorder of occlusion textures.
#[derive(Debug)]
pub struct SliceNode {
    pub(super) layouts: Arc<SliceLayouts>,
    pub(super) pipelines: Variants<Key>,
    pub(super) pool: TexturePool,
    pub(super) draws: MapDraws,
    casters: GrowingBuffer,
    pub(super) caster_group: wgpu::BindGroup,
    face_records: StridedUniforms<OcclusionFace>,
    pub(super) face_group: wgpu::BindGroup,
    light_records: StridedUniforms<OcclusionLight>,
    pub(super) light_group: wgpu::BindGroup,
    pub(super) lights: Vec<LightPlan>,
    pub(super) faces: Vec<FacePlan>,
}

impl SliceNode {
    /// Compiles the shaders. Pipelines and textures are made when a frame needs them.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        gpu.compile(&FILES)?;
        let context = &gpu.context;
        let layouts = gpu.part(|gpu| SliceLayouts::new(&gpu.context.device));
        let casters = GrowingBuffer::new(context, "slice casters", wgpu::BufferUsages::STORAGE);
        let face_records = StridedUniforms::new(context, "slice faces");
        let light_records = StridedUniforms::new(context, "slice lights");
        Ok(Self {
            pipelines: Variants::default(),
            pool: TexturePool::default(),
            draws: MapDraws::default(),
            caster_group: bind_casters(context, &layouts, &casters),
            face_group: bind_faces(context, &layouts, &face_records),
            light_group: bind_lights(context, &layouts, &light_records),
            lights: Vec::new(),
            faces: Vec::new(),
            layouts,
            casters,
            face_records,
            light_records,
        })
    }

    pub(super) fn plan_of(&self, light: usize) -> Option<(usize, &LightPlan)> {
        let at = self.lights.binary_search_by_key(&light, |plan| plan.light).ok()?;
        Some((at, &self.lights[at]))
    }

    /// Requests a pipeline from the shared cache.
    fn require(&mut self, gpu: &Gpu, key: Key) -> Result<(), RenderError> {
        let layouts = &self.layouts;
        gpu.require(&mut self.pipelines, key, |gpu| describe(gpu, layouts, key))
    }

    /// Plans the draws of a light's pictures, and returns their range.
    fn plan_faces(
        &mut self,
        world: &World,
        input: &PrepareInput,
        slices: &LightSlices,
    ) -> Result<Range<usize>, RenderError> {
        let objects = world.resource::<Objects>();
        let first = self.faces.len();
        let groups = slices.settings.groups();
        let key = TexturesKey::new(slices);
        for face in &slices.faces {
            let drawn = face.drawn();
            let (fronts, backs) = if face.is_mirrored() {
                (wgpu::Face::Back, wgpu::Face::Front)
            } else {
                (wgpu::Face::Front, wgpu::Face::Back)
            };
            let measures = slices.settings.measures();
            // Which casters: whether they close leaks, and are closed. How: whether they fill the next slice, and what is culled.
            let sets = [
                ((false, false), (false, None)),
                ((false, true), (false, (!measures).then_some(backs))),
                ((true, false), (true, None)),
                ((true, true), (true, Some(backs))),
                // Nothing is behind the back of a closed caster, so it does not fill the next slice.
                ((true, true), (false, Some(fronts))),
            ];
            let plan = sets.map(|((is_closing, is_solid), (closes, culled))| {
                let is_drawn = measures || culled != Some(fronts);
                let own = |object: &usize| {
                    is_drawn
                        && slices.closing.contains(*object) == is_closing
                        && slices.solid.contains(*object) == is_solid
                        && slices.shows(face, objects, *object)
                };
                let set = slices.casters.ones().filter(own).collect();
                SetPlan {
                    draws: self.draws.push(world, input, objects, &drawn, &set),
                    closes,
                    culled,
                }
            });
            for set in &plan {
                let SetPlan { closes, culled, .. } = *set;
                for masked in self.draws.masked(set.draws.clone()) {
                    let caster = Key::Caster {
                        masked,
                        closes,
                        culled,
                        depths: key.is_split,
                        format: key.drawn_format(),
                        groups,
                    };
                    self.require(input.gpu, caster)?;
                }
            }
            let own =
                |object: &usize| slices.fills(face, objects, *object) && slices.shows(face, objects, *object);
            let set = slices.solid.ones().filter(own).collect();
            let filled = self.draws.push(world, input, objects, &drawn, &set);
            if !filled.is_empty() {
                self.require(input.gpu, Key::Crossings { groups })?;
                self.require(input.gpu, Key::Fill { groups })?;
            }
            self.faces.push(FacePlan { draws: plan, filled });
            self.face_records.constants.push(&face.record(face.origin));
        }
        for step in key.steps() {
            self.require(input.gpu, step)?;
        }
        Ok(first..self.faces.len())
    }

    fn plan_light(
        &mut self,
        world: &World,
        input: &PrepareInput,
        slices: &LightSlices,
        view: &ViewData,
    ) -> Result<(), RenderError> {
        let key = TexturesKey::new(slices);
        self.pool.require(input.context, &self.layouts, key);
        let held = self
            .pool
            .get(&key)
            .map_or(0, |textures| textures.record.shown.load(Ordering::Relaxed));
        let faces = if held == slices.revision {
            0..0
        } else {
            self.plan_faces(world, input, slices)?
        };
        let lookup = Key::Resolve {
            filter: slices.settings.filter,
            combine: slices.settings.combine,
            slices: slices.settings.slices,
            faces: key.faces,
            closes: slices.settings.close_leaks != 0,
        };
        self.require(input.gpu, lookup)?;
        let light = &world.resource::<FrameLights>().lights[slices.light];
        let bounds = light.region.depth_bounds;
        let bounds = bounds.map_or((1.0, 0.0), |bounds| (bounds.depth_max, bounds.depth_min));
        self.light_records
            .constants
            .push(&slices.record(light, view.eye, bounds));
        self.lights.push(LightPlan {
            light: slices.light,
            key,
            lookup,
            faces,
            levels: slices.levels(),
            revision: slices.revision,
        });
        Ok(())
    }
}

fn bind_casters(context: &RenderContext, layouts: &SliceLayouts, casters: &GrowingBuffer) -> wgpu::BindGroup {
    let buffer = casters.buffer.as_entire_binding();
    bind_in_order(&context.device, "slice casters", &layouts.casters, [buffer])
}

fn bind_faces(
    context: &RenderContext,
    layouts: &SliceLayouts,
    faces: &StridedUniforms<OcclusionFace>,
) -> wgpu::BindGroup {
    bind_in_order(&context.device, "slice face", &layouts.face, [faces.binding()])
}

fn bind_lights(
    context: &RenderContext,
    layouts: &SliceLayouts,
    lights: &StridedUniforms<OcclusionLight>,
) -> wgpu::BindGroup {
    bind_in_order(&context.device, "slice light", &layouts.light, [lights.binding()])
}

impl Recorder for SliceNode {
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError> {
        self.lights.clear();
        self.faces.clear();
        self.draws.clear();
        self.face_records.constants.clear();
        self.light_records.constants.clear();
        let Some(textures) = world.get_resource::<OcclusionTextures>() else {
            return Ok(());
        };
        let Some(view) = world.get_resource::<View>().and_then(|view| view.data.as_ref()) else {
            return Ok(());
        };
        self.pool.begin();
        for slices in &textures.lights {
            if slices.is_active {
                self.plan_light(world, input, slices, view)?;
            } else if slices.resolution > 0 {
                self.pool.keep(&TexturesKey::new(slices));
            }
        }
        self.pool.end();
        let context = input.context;
        if self
            .casters
            .write(context, bytemuck::cast_slice(&self.draws.casters))
        {
            self.caster_group = bind_casters(context, &self.layouts, &self.casters);
        }
        if self.face_records.write(context) {
            self.face_group = bind_faces(context, &self.layouts, &self.face_records);
        }
        if self.light_records.write(context) {
            self.light_group = bind_lights(context, &self.layouts, &self.light_records);
        }
        Ok(())
    }

    fn draw_pictures(&self, encoder: &mut wgpu::CommandEncoder, input: &PictureInput) {
        let mut recorded = Recorded::default();
        for plan in self.lights.iter().filter(|plan| !plan.faces.is_empty()) {
            if let Some(textures) = self.pool.get(&plan.key) {
                self.draw_light(plan, textures, encoder, input);
                recorded.push(&textures.record, plan.revision, plan.revision);
            }
        }
        recorded.confirm_on_submission(encoder);
    }

    fn light(&self, light: usize) -> Option<Leaves<'_>> {
        self.plan_of(light).map(|_| Leaves::Mask(self))
    }

    /// Draws nothing: pictures have no geometry on the screen.
    fn debug(&self, _light: usize, _pass: &mut wgpu::RenderPass, _input: &RecordInput) {}

    /// Returns the number of draws of casters. It leaves out the filter and the lookup, which draw one triangle each.
    fn batch_count(&self, light: usize) -> usize {
        let plan = self.plan_of(light);
        let faces = plan.map_or(&[][..], |(_, plan)| &self.faces[plan.faces.clone()]);
        let draws = |face: &FacePlan| {
            let sets = face.draws.iter().map(|set| set.draws.len());
            sets.sum::<usize>() + face.filled.len()
        };
        faces.iter().map(draws).sum()
    }
}

impl Resolve for SliceNode {
    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        let Some((slot, plan)) = self.plan_of(light) else {
            return;
        };
        if let (Some(textures), Some(pipeline)) = (self.pool.get(&plan.key), self.pipelines.get(plan.lookup))
        {
            self.look_up(slot, &textures.group, pipeline, encoder, input);
        }
    }
}
