//! Draws perspective maps and the pictures of blurred grounds, and looks both up into the mask.
//!
//! Shaders `shaders/techniques/maps/*.wgsl`, `shaders/techniques/perspective_map/{color,blur,ground}.wgsl`
//! Groups  colours: 0 casters, 1 channels, 2 material; blur: 1 grounds, 2 map, 3 picture;
//!         lookup of grounds: 0 view, 1 channels, 2 map, 3 picture
//! Reads   receiver depth and plane, scene depth (equal).  Writes  the mask, inside the light's scissor
//! Order   after `depth copy` and `receiver plane`, before `light_accumulate` of the same light
//!
//! The recorder of maps draws the faces and looks them up. A light that lights a blurred ground keeps nothing from frame
//! to frame: the colours of its casters are drawn after each face, where their depth equals that of the map.

use std::ops::Range;
use std::sync::Arc;

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;

use super::gpu_types::Grounds;
use super::pictures::{PicturePool, Pictures};
use super::pipelines::{FILES, GroundLayouts, Key, describe};
use crate::render::gpu::bind_groups::bind_in_order;
use crate::render::gpu::buffers::GrowingBuffer;
use crate::render::gpu::pipeline_cache::Variants;
use crate::render::recorder::{
    Leaves, PictureInput, PrepareInput, RecordInput, Recorder, Resolve, ResolveInput,
};
use crate::render::{Gpu, RenderContext, RenderError};
use crate::sets::{FrameLights, Objects, View};
use crate::techniques::maps::Maps;
use crate::techniques::maps::gpu::draws::MapDraws;
use crate::techniques::maps::gpu::recorded::Recorded;
use crate::techniques::maps::gpu::recorder::MapNode;
use crate::techniques::perspective_map::grounds::{BlurredGrounds, MOST_GROUNDS};

/// The channels of the casters of draws, or of all objects.
#[derive(Debug)]
pub struct Channels {
    /// Group 1 of the passes that read them.
    pub group: wgpu::BindGroup,
    values: Vec<u32>,
    buffer: GrowingBuffer,
}

impl Channels {
    fn new(context: &RenderContext, layouts: &GroundLayouts, label: &'static str) -> Self {
        let buffer = GrowingBuffer::new(context, label, wgpu::BufferUsages::STORAGE);
        Self {
            group: bind_channels(context, layouts, &buffer),
            values: Vec::new(),
            buffer,
        }
    }

    fn write(&mut self, context: &RenderContext, layouts: &GroundLayouts, values: impl Iterator<Item = u32>) {
        self.values.clear();
        self.values.extend(values);
        if self.buffer.write(context, bytemuck::cast_slice(&self.values)) {
            self.group = bind_channels(context, layouts, &self.buffer);
        }
    }
}

fn bind_channels(
    context: &RenderContext,
    layouts: &GroundLayouts,
    buffer: &GrowingBuffer,
) -> wgpu::BindGroup {
    let resource = buffer.buffer.as_entire_binding();
    bind_in_order(&context.device, "ground channels", &layouts.channels, [resource])
}

/// The recorder of perspective maps.
#[derive(Debug)]
pub struct PerspectiveNode {
    pub(super) maps: MapNode,
    layouts: Arc<GroundLayouts>,
    pub(super) pipelines: Variants<Key>,
    /// Draws of grounds that cast nothing.
    pub(super) others: MapDraws,
    other_casters: GrowingBuffer,
    pub(super) other_group: wgpu::BindGroup,
    pub(super) other_channels: Channels,
    pub(super) caster_channels: Channels,
    pub(super) object_channels: Channels,
    grounds: wgpu::Buffer,
    pub(super) ground_group: wgpu::BindGroup,
    pictures: PicturePool,
    /// The light of each slot that lights a blurred ground.
    lights: Vec<Option<Entity>>,
    /// Range of `others` for each face, in the order of the recorder of maps.
    pub(super) plans: Vec<Range<usize>>,
    set: FixedBitSet,
}

impl PerspectiveNode {
    /// Compiles the shaders. Pipelines and textures are made when a frame needs them.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        gpu.compile(&FILES)?;
        let context = &gpu.context;
        let layouts = gpu.part(|gpu| GroundLayouts::new(&gpu.context.device));
        let maps = MapNode::new(gpu)?;
        let other_casters =
            GrowingBuffer::new(context, "grounds that cast nothing", wgpu::BufferUsages::STORAGE);
        let grounds = context.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("grounds"),
            size: size_of::<Grounds>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let resource = grounds.as_entire_binding();
        Ok(Self {
            other_group: maps
                .long_lived
                .layouts
                .bind_casters(context, &other_casters.buffer),
            ground_group: bind_in_order(&context.device, "grounds", &layouts.grounds, [resource]),
            other_channels: Channels::new(context, &layouts, "channels of grounds that cast nothing"),
            caster_channels: Channels::new(context, &layouts, "channels of casters"),
            object_channels: Channels::new(context, &layouts, "channels of objects"),
            maps,
            layouts,
            pipelines: Variants::default(),
            others: MapDraws::default(),
            other_casters,
            grounds,
            pictures: PicturePool::default(),
            lights: Vec::new(),
            plans: Vec::new(),
            set: FixedBitSet::new(),
        })
    }

    /// The pictures of the light of a slot, if it lights a blurred ground.
    pub(super) fn pictures_of(&self, slot: usize) -> Option<&Pictures> {
        self.pictures.get((*self.lights.get(slot)?)?)
    }

    fn require(&mut self, gpu: &Gpu, key: Key) -> Result<(), RenderError> {
        let (layouts, maps) = (&self.layouts, &self.maps.long_lived.layouts);
        gpu.require(&mut self.pipelines, key, |gpu| describe(gpu, layouts, maps, key))
    }

    /// Plans the pictures of one light.
    fn plan_light(
        &mut self,
        world: &World,
        input: &PrepareInput,
        slot: usize,
        grounds: &BlurredGrounds,
    ) -> Result<(), RenderError> {
        let plan = &self.maps.lights[slot];
        let (range, request, side) = (plan.faces.clone(), plan.request, plan.key.side);
        let map = world.resource::<Maps>().of_light(plan.light);
        let Some(map) = map.filter(|map| request.pictures && !map.cached) else {
            self.plans.resize(range.end, 0..0);
            self.lights.push(None);
            return Ok(());
        };
        let objects = world.resource::<Objects>();
        let lit = &world.resource::<FrameLights>().lights[plan.light].sets.i;
        for at in range {
            let state = &map.faces[self.maps.faces[at].face];
            self.set.clear();
            self.set.grow(objects.len());
            for (object, _) in &grounds.receivers {
                self.set
                    .set(*object, lit.contains(*object) && !state.moving.contains(*object));
            }
            let others = self.others.push(world, input, objects, &state.face, &self.set);
            self.plans.push(others.clone());
            let casters = self.maps.faces[at].still.clone().unwrap_or(0..0);
            for (masked, casts) in (self.maps.draws.masked(casters).map(|masked| (masked, true)))
                .chain(self.others.masked(others).map(|masked| (masked, false)))
            {
                self.require(input.gpu, Key::Color { masked, casts })?;
            }
        }
        self.lights.push(Some(map.entity));
        let layouts = &self.layouts;
        self.pictures
            .require(input.context, layouts, map.entity, side, request.layers);
        Ok(())
    }

    /// Uploads grounds and channels.
    fn write(&mut self, world: &World, context: &RenderContext, grounds: &BlurredGrounds) {
        let Some(view) = world.resource::<View>().data.as_ref() else {
            return;
        };
        let constants = Grounds::new(&grounds.grounds, view.eye);
        context
            .queue
            .write_buffer(&self.grounds, 0, bytemuck::bytes_of(&constants));
        if self
            .other_casters
            .write(context, bytemuck::cast_slice(&self.others.casters))
        {
            let layouts = &self.maps.long_lived.layouts;
            self.other_group = layouts.bind_casters(context, &self.other_casters.buffer);
        }
        let none = MOST_GROUNDS as u32;
        let channel = |object: usize| grounds.channel_of(object).unwrap_or(none);
        let layouts = &self.layouts;
        let of_draw = |object: &u32| channel(*object as usize);
        let casters = self.maps.draws.objects.iter().map(of_draw);
        self.caster_channels.write(context, layouts, casters);
        let others = self.others.objects.iter().map(of_draw);
        self.other_channels.write(context, layouts, others);
        let count = world.resource::<Objects>().len();
        self.object_channels
            .write(context, layouts, (0..count).map(channel));
    }
}

impl Recorder for PerspectiveNode {
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError> {
        self.maps
            .prepare_maps(world, input, |request| request.apart && request.beside.is_none())?;
        self.others.clear();
        self.plans.clear();
        self.lights.clear();
        self.pictures.begin();
        if let Some(grounds) = world.get_resource::<BlurredGrounds>() {
            for slot in 0..self.maps.lights.len() {
                self.plan_light(world, input, slot, grounds)?;
            }
            if self.lights.iter().any(Option::is_some) {
                for key in [Key::Blur { axis: 0 }, Key::Blur { axis: 1 }, Key::Ground] {
                    self.require(input.gpu, key)?;
                }
                self.write(world, input.context, grounds);
            }
        }
        self.pictures.end();
        Ok(())
    }

    fn draw_pictures(&self, encoder: &mut wgpu::CommandEncoder, input: &PictureInput) {
        let mut recorded = Recorded::default();
        for (slot, plan) in self.maps.keepers() {
            self.draw_light(slot, plan, encoder, input, &mut recorded);
        }
        recorded.confirm_on_submission(encoder);
    }

    fn light(&self, light: usize) -> Option<Leaves<'_>> {
        self.maps.plan_of(light).map(|_| Leaves::Mask(self))
    }

    /// Draws the edges of the volumes that the faces show.
    fn debug(&self, light: usize, pass: &mut wgpu::RenderPass, input: &RecordInput) {
        self.maps.debug(light, pass, input);
    }

    /// Returns the number of draws of casters and, in colour, of casters and grounds. It leaves out the blur and the lookup.
    fn batch_count(&self, light: usize) -> usize {
        let of_maps = self.maps.batch_count(light);
        let Some((slot, plan)) = self.maps.plan_of(light) else {
            return of_maps;
        };
        if self.pictures_of(slot).is_none() {
            return of_maps;
        }
        let others: usize = self.plans[plan.faces.clone()].iter().map(Range::len).sum();
        2 * of_maps + others
    }
}

impl Resolve for PerspectiveNode {
    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        let Some((slot, plan)) = self.maps.plan_of(light) else {
            return;
        };
        if plan.takes_turns {
            // Another light may have used the depth since, so faces are drawn before each lookup.
            self.draw_light(slot, plan, encoder, &input.pictures(), &mut Recorded::default());
        }
        self.maps.look_up_light(slot, plan, encoder, input);
        self.look_up_grounds(slot, encoder, input);
    }
}
