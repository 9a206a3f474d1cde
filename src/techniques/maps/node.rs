//! Draws the maps that changed and looks them up into the mask.
//!
//! Shaders `shaders/techniques/maps/{caster,convert,resolve}.wgsl`
//! Groups  casters: 0 casters, 1 first surface, 2 material; conversion: 1 surfaces, 2 map; lookup: 0 view, 1 receiver,
//!         2 map, 3 textures
//! Reads   receiver depth and plane.  Writes  the mask, inside the light's scissor
//! Order   after `depth copy` and `receiver plane`, before `light_accumulate` of the same light
//!
//! Each face: still casters into their layer; a copy of it, and over it what moves; from that, where depth of the nearest
//! surface is not what is looked up, the second surface and a conversion. Each step is left out while its revision is
//! that of the last time.

use std::ops::Range;
use std::sync::atomic::Ordering;

use bevy_ecs::prelude::*;
use glam::DVec3;

use super::cache::{FaceState, LightMap, Maps};
use super::face::FaceProjection;
use super::jitter;
use super::map_draws::MapDraws;
use super::map_pipelines::{Key, MapPipelines, filter_constant};
use super::map_pool::{MapPool, MapTextures, MapTexturesKey};
use super::packing::{FOUR_BYTES_STEP, TWO_BYTES_STEP};
use super::request::{MapComponent, MapRequest, MapShape};
use super::settings::{MapBias, MapFilter, MapFormat, MapSettings, MapSurface};
use crate::render::bind_groups::BindGroupLayouts;
use crate::render::buffers::GrowingBuffer;
use crate::render::gpu_types;
use crate::render::technique::{PrepareInput, RecordInput, ResolveInput, ShadowTechnique, Visibility};
use crate::render::{RenderContext, RenderError, Shaders};
use crate::sets::{FrameLights, Objects, View};

/// Bytes between the constants of lights.
const STRIDE: usize = 512;

/// What is to be drawn of one face.
#[derive(Debug)]
struct FacePlan {
    face: usize,
    still: Option<Range<usize>>,
    /// Over a copy of the still layer.
    moving: Option<Range<usize>>,
    /// All casters, for the second surface; empty for the nearest.
    peeled: [Range<usize>; 2],
    still_revision: u64,
    revision: u64,
}

/// What is to be done for one light.
#[derive(Debug)]
struct LightPlan {
    light: usize,
    request: MapRequest,
    key: MapTexturesKey,
    lookup: Key,
    faces: Range<usize>,
    draw_count: usize,
}

/// The recorder of one of the two components.
#[derive(Debug)]
pub struct MapNode {
    component: MapComponent,
    pipelines: MapPipelines,
    pool: MapPool,
    draws: MapDraws,
    casters: GrowingBuffer,
    caster_group: wgpu::BindGroup,
    constants: GrowingBuffer,
    constant_bytes: Vec<u8>,
    compare: wgpu::Sampler,
    jitter: wgpu::TextureView,
    map_group: wgpu::BindGroup,
    lights: Vec<LightPlan>,
    faces: Vec<FacePlan>,
}

impl MapComponent {
    /// Name of the technique.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Shadow => "shadow_map",
            Self::Omni => "omni_map",
        }
    }
}

impl MapNode {
    /// Compiles the shaders; pipelines and textures come when a frame needs them.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(
        component: MapComponent,
        context: &RenderContext,
        shaders: &Shaders,
        layouts: &BindGroupLayouts,
    ) -> Result<Self, RenderError> {
        let pipelines = MapPipelines::new(context, shaders, layouts)?;
        let casters = GrowingBuffer::new(context, "map casters", wgpu::BufferUsages::STORAGE);
        let constants = GrowingBuffer::new(context, "maps", wgpu::BufferUsages::UNIFORM);
        let compare = context.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("map comparison"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            // Depth is reversed: lit where the receiver's is not less than the map's.
            compare: Some(wgpu::CompareFunction::GreaterEqual),
            ..Default::default()
        });
        let jitter = jitter_texture(context);
        Ok(Self {
            component,
            caster_group: bind_casters(context, &pipelines, &casters.buffer),
            map_group: bind_map(context, &pipelines, &constants.buffer, &compare, &jitter),
            pool: MapPool::new(context),
            draws: MapDraws::default(),
            constant_bytes: Vec::new(),
            lights: Vec::new(),
            faces: Vec::new(),
            pipelines,
            casters,
            constants,
            compare,
            jitter,
        })
    }

    /// Bytes of all its textures.
    pub fn texture_bytes(&self) -> u64 {
        self.pool.bytes()
    }

    fn plan_of(&self, light: usize) -> Option<(usize, &LightPlan)> {
        let at = self.lights.binary_search_by_key(&light, |plan| plan.light).ok()?;
        Some((at, &self.lights[at]))
    }

    /// Plans the draws of one face; `None` if it is as it should be.
    fn plan_face(
        &mut self,
        world: &World,
        input: &PrepareInput,
        map: &LightMap,
        face: usize,
        key: &MapTexturesKey,
    ) -> Option<FacePlan> {
        let objects = world.resource::<Objects>();
        let state: &FaceState = &map.faces[face];
        let record = &self.pool.get(key)?.records[face];
        let has = |at: &std::sync::atomic::AtomicU64| at.load(Ordering::Relaxed);
        let draw_still = !map.cached || has(&record.still) != state.still_revision;
        let refresh = draw_still || has(&record.shown) != state.revision;
        if !refresh {
            return None;
        }
        let mut push = |set| self.draws.push(world, input, objects, &state.face, set);
        // A map that is not kept has one layer, with all its casters.
        let own = if map.cached { &state.still } else { &state.moving };
        let still = draw_still.then(|| push(own));
        let moving = key.moving.then(|| push(&state.moving));
        let peeled = if map.request.surface == MapSurface::Nearest {
            [0..0, 0..0]
        } else {
            let over = moving.clone().unwrap_or(0..0);
            [still.clone().unwrap_or_else(|| push(own)), over]
        };
        for (range, peel) in [(&still, false), (&moving, false)] {
            self.draws
                .require(range.clone().unwrap_or(0..0), peel, input, &mut self.pipelines);
        }
        for range in &peeled {
            self.draws.require(range.clone(), true, input, &mut self.pipelines);
        }
        Some(FacePlan {
            face,
            still,
            moving,
            peeled,
            still_revision: state.still_revision,
            revision: state.revision,
        })
    }

    fn plan_light(&mut self, world: &World, input: &PrepareInput, map: &LightMap, eye: DVec3, show_taps: bool) {
        let moving = map.has_moving();
        let key = MapTexturesKey::new(map.cached.then_some(map.entity), &map.request, map.resolution, moving);
        self.pool.require(input.context, &self.pipelines.layouts, key);
        let first_face = self.faces.len();
        let first_draw = self.draws.draws.len();
        for face in 0..map.faces.len() {
            let plan = self.plan_face(world, input, map, face, &key);
            self.faces.extend(plan);
        }
        let request = map.request;
        let parallel = request.shape == MapShape::Cascades;
        if request.has_final() {
            let (format, surface) = (request.format, request.surface);
            let convert = Key::Convert {
                format,
                surface,
                parallel,
            };
            self.pipelines.require(input.context, convert);
        }
        let lookup = Key::Resolve {
            filter: filter_constant(request.filter),
            shape: request.shape,
            cascade_count: if parallel { request.face_count() } else { 1 },
            format: request.format,
            show_taps,
        };
        self.pipelines.require(input.context, lookup);
        let lights = world.resource::<FrameLights>();
        let bounds = lights.lights[map.light].depth_bounds;
        let bounds = bounds.map_or((1.0, 0.0), |bounds| (bounds.depth_max, bounds.depth_min));
        let at = self.constant_bytes.len();
        self.constant_bytes.resize(at + STRIDE, 0);
        let constants = map_constants(map, eye, bounds);
        self.constant_bytes[at..at + size_of::<gpu_types::MapLight>()]
            .copy_from_slice(bytemuck::bytes_of(&constants));
        self.lights.push(LightPlan {
            light: map.light,
            request,
            key,
            lookup,
            faces: first_face..self.faces.len(),
            draw_count: self.draws.draws.len() - first_draw,
        });
    }

    /// Records what one face needs.
    fn draw_face(
        &self,
        slot: usize,
        plan: &LightPlan,
        face: &FacePlan,
        textures: &MapTextures,
        encoder: &mut wgpu::CommandEncoder,
        input: &ResolveInput,
    ) {
        let layer = face.face;
        if let Some(range) = &face.still {
            let view = &textures.still.layers[layer];
            self.draw_casters(encoder, input, view, true, &[range.clone()], None);
        }
        if let (Some(range), Some(moving)) = (&face.moving, &textures.moving) {
            copy_layer(encoder, &textures.still.texture, &moving.texture, layer);
            if !range.is_empty() {
                self.draw_casters(encoder, input, &moving.layers[layer], false, &[range.clone()], None);
            }
        }
        if let Some(shown) = &textures.shown {
            let first = &textures.all_casters().layers[layer];
            let mut second = first;
            if plan.request.surface != MapSurface::Nearest
                && let Some(scratch) = self.pool.second(plan.key.side)
            {
                let group = bind_depths(input.context, &self.pipelines.layouts.first, &[first]);
                self.draw_casters(encoder, input, scratch, true, &face.peeled, Some(&group));
                second = scratch;
            }
            let group = bind_depths(input.context, &self.pipelines.layouts.surfaces, &[first, second]);
            self.convert(slot, plan, layer, &shown.layers[layer], &group, encoder, input);
        }
        let record = &textures.records[layer];
        record.still.store(face.still_revision, Ordering::Relaxed);
        record.shown.store(face.revision, Ordering::Relaxed);
    }

    fn draw_casters(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        input: &ResolveInput,
        target: &wgpu::TextureView,
        clear: bool,
        ranges: &[Range<usize>],
        peel: Option<&wgpu::BindGroup>,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("map"),
            color_attachments: &[],
            depth_stencil_attachment: Some(depth_attachment(target, clear)),
            timestamp_writes: pass_timer(input, "map"),
            ..Default::default()
        });
        pass.set_bind_group(0, &self.caster_group, &[]);
        if let Some(group) = peel {
            pass.set_bind_group(1, group, &[]);
        }
        for range in ranges {
            self.draws.record(
                range.clone(),
                peel.is_some(),
                &mut pass,
                &self.pipelines,
                input.record.meshes,
                input.record.materials,
            );
        }
    }

    fn convert(
        &self,
        slot: usize,
        plan: &LightPlan,
        face: usize,
        target: &wgpu::TextureView,
        surfaces: &wgpu::BindGroup,
        encoder: &mut wgpu::CommandEncoder,
        input: &ResolveInput,
    ) {
        let (format, surface) = (plan.request.format, plan.request.surface);
        let parallel = plan.request.shape == MapShape::Cascades;
        let key = Key::Convert {
            format,
            surface,
            parallel,
        };
        let Some(pipeline) = self.pipelines.get(key) else {
            return;
        };
        let is_depth = format == MapFormat::Depth;
        let color = [Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
                store: wgpu::StoreOp::Store,
            },
        })];
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("map conversion"),
            color_attachments: if is_depth { &[] } else { &color },
            depth_stencil_attachment: is_depth.then(|| depth_attachment(target, true)),
            timestamp_writes: pass_timer(input, "map conversion"),
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(1, surfaces, &[]);
        pass.set_bind_group(2, &self.map_group, &[(slot * STRIDE) as u32]);
        pass.draw(0..3, face as u32..face as u32 + 1);
    }
}

/// A name is made only where somebody looks at it.
fn pass_timer<'a>(input: &'a ResolveInput, pass: &str) -> Option<wgpu::RenderPassTimestampWrites<'a>> {
    let is_active = input.timings.is_active();
    is_active.then(|| input.timings.pass(&format!("{}/{pass}", input.label)))?
}

fn depth_attachment(
    view: &wgpu::TextureView,
    clear: bool,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: if clear {
                wgpu::LoadOp::Clear(crate::conventions::DEPTH_INFINITY)
            } else {
                wgpu::LoadOp::Load
            },
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    }
}

fn copy_layer(encoder: &mut wgpu::CommandEncoder, from: &wgpu::Texture, to: &wgpu::Texture, layer: usize) {
    let at = |texture| wgpu::TexelCopyTextureInfo {
        texture,
        mip_level: 0,
        origin: wgpu::Origin3d {
            x: 0,
            y: 0,
            z: layer as u32,
        },
        aspect: wgpu::TextureAspect::All,
    };
    let size = wgpu::Extent3d {
        depth_or_array_layers: 1,
        ..from.size()
    };
    encoder.copy_texture_to_texture(at(from), at(to), size);
}

fn bind_depths(
    context: &RenderContext,
    layout: &wgpu::BindGroupLayout,
    views: &[&wgpu::TextureView],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(views)
        .map(|(binding, view)| wgpu::BindGroupEntry {
            binding,
            resource: wgpu::BindingResource::TextureView(view),
        })
        .collect();
    context.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("map surfaces"),
        layout,
        entries: &entries,
    })
}

fn bind_casters(context: &RenderContext, pipelines: &MapPipelines, buffer: &wgpu::Buffer) -> wgpu::BindGroup {
    context.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("map casters"),
        layout: &pipelines.layouts.casters,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: buffer.as_entire_binding(),
        }],
    })
}

fn bind_map(
    context: &RenderContext,
    pipelines: &MapPipelines,
    buffer: &wgpu::Buffer,
    compare: &wgpu::Sampler,
    jitter: &wgpu::TextureView,
) -> wgpu::BindGroup {
    context.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("map"),
        layout: &pipelines.layouts.map,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer,
                    offset: 0,
                    size: std::num::NonZeroU64::new(size_of::<gpu_types::MapLight>() as u64),
                }),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::Sampler(compare),
            },
            wgpu::BindGroupEntry {
                binding: 2,
                resource: wgpu::BindingResource::TextureView(jitter),
            },
        ],
    })
}

fn jitter_texture(context: &RenderContext) -> wgpu::TextureView {
    use wgpu::util::DeviceExt;
    let texture = context.device.create_texture_with_data(
        &context.queue,
        &wgpu::TextureDescriptor {
            label: Some("jitter"),
            size: wgpu::Extent3d {
                width: jitter::TILE,
                height: jitter::TILE,
                depth_or_array_layers: jitter::DEPTH,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format: wgpu::TextureFormat::Rgba8Snorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::wgt::TextureDataOrder::LayerMajor,
        &jitter::texels(),
    );
    texture.create_view(&Default::default())
}

/// Share of a texel by which a plane is raised, and half of it for each texel of the filter's radius: enough for surfaces
/// that bend by some 8° between neighbouring texels, too little to part a shadow from its caster. Found by
/// `tests/maps/contacts.rs`.
const RAISED_TEXELS: f32 = 0.15;

/// The shader's view of one light's map.
fn map_constants(map: &LightMap, eye: DVec3, depth_bounds: (f32, f32)) -> gpu_types::MapLight {
    let request = &map.request;
    let mut constants = gpu_types::MapLight::default();
    let mut radius_texels: f32 = 0.0;
    let softness = request.filter.softness().unwrap_or(0.0);
    for (out, state) in constants.faces.iter_mut().zip(&map.faces) {
        let [x, y, z] = state.face.rows_from_relative(eye);
        let texel = state.face.texel_metres(map.resolution) as f32;
        let (a, b) = match state.face.projection {
            FaceProjection::Perspective { tangent, near } => (tangent, near),
            FaceProjection::Parallel { half, length } => (half, length),
        };
        *out = gpu_types::MapFace {
            row_x: x.to_array(),
            row_y: y.to_array(),
            row_z: z.to_array(),
            projection: [a as f32, b as f32, texel, 0.0],
        };
        radius_texels = radius_texels.max(softness / texel);
    }
    if matches!(request.filter, MapFilter::Brute4x4 | MapFilter::Dithered4) {
        radius_texels = 2.0;
    }
    let (raised, metres) = match request.bias {
        MapBias::Auto => (RAISED_TEXELS * (1.0 + 0.5 * radius_texels), 0.0),
        MapBias::Manual {
            normal_texels,
            depth_metres,
        } => (normal_texels, depth_metres),
    };
    // A few roundings of f32 on both sides of the comparison; squares have twice the share.
    let parallel = request.shape == MapShape::Cascades;
    let (relative, absolute) = match request.format {
        MapFormat::Depth if parallel => (0.0, 2e-6),
        MapFormat::Depth => (4e-6, 0.0),
        MapFormat::R32Float => (8e-6, 0.0),
        MapFormat::Rgba8TwoBytes => (8e-6, TWO_BYTES_STEP),
        MapFormat::Rgba8FourBytes => (8e-6, FOUR_BYTES_STEP),
    };
    let resolution = map.resolution as f32;
    constants.size = [resolution, resolution.recip(), softness, 0.0];
    constants.bias = [raised, relative, absolute, metres];
    let inverse_reach_sq = (map.reach * map.reach).recip() as f32;
    constants.limits = [depth_bounds.0, depth_bounds.1, inverse_reach_sq, request.cascades.blend];
    constants
}

impl ShadowTechnique for MapNode {
    fn name(&self) -> &'static str {
        self.component.name()
    }

    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError> {
        self.lights.clear();
        self.faces.clear();
        self.draws.clear();
        self.constant_bytes.clear();
        let (Some(maps), Some(settings)) = (world.get_resource::<Maps>(), world.get_resource::<MapSettings>()) else {
            return Ok(());
        };
        let Some(view) = world.get_resource::<View>().and_then(|view| view.data.as_ref()) else {
            return Ok(());
        };
        self.pool.begin();
        for map in &maps.lights {
            if map.request.component != self.component {
                continue;
            }
            if map.active {
                self.plan_light(world, input, map, view.eye, settings.show_taps);
            } else if map.cached {
                let moving = map.has_moving();
                let key = MapTexturesKey::new(Some(map.entity), &map.request, map.resolution, moving);
                self.pool.keep(&key);
            }
        }
        self.pool.end();
        let context = input.context;
        if self
            .casters
            .write(context, bytemuck::cast_slice(&self.draws.casters))
        {
            self.caster_group = bind_casters(context, &self.pipelines, &self.casters.buffer);
        }
        if self.constants.write(context, &self.constant_bytes) {
            let buffer = &self.constants.buffer;
            self.map_group = bind_map(context, &self.pipelines, buffer, &self.compare, &self.jitter);
        }
        Ok(())
    }

    fn visibility(&self, light: usize) -> Option<Visibility> {
        self.plan_of(light).map(|_| Visibility::Mask)
    }

    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        let Some((slot, plan)) = self.plan_of(light) else {
            return;
        };
        let (Some(textures), Some(pipeline)) = (self.pool.get(&plan.key), self.pipelines.get(plan.lookup)) else {
            return;
        };
        for face in &self.faces[plan.faces.clone()] {
            self.draw_face(slot, plan, face, textures, encoder, input);
        }
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("map lookup"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &input.masks.mask_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Load,
                    store: wgpu::StoreOp::Store,
                },
            })],
            timestamp_writes: pass_timer(input, "map lookup"),
            ..Default::default()
        });
        let [x, y, width, height] = input.scissor;
        pass.set_scissor_rect(x, y, width, height);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, input.record.view, &[]);
        pass.set_bind_group(1, &input.masks.receiver_group, &[]);
        pass.set_bind_group(2, &self.map_group, &[(slot * STRIDE) as u32]);
        pass.set_bind_group(3, &textures.group, &[]);
        pass.draw(0..3, 0..1);
    }

    fn reads_planes(&self) -> bool {
        true
    }

    fn debug(&self, _light: usize, _pass: &mut wgpu::RenderPass, _input: &RecordInput) {}

    /// Draws of casters; the lookup is one more, of one triangle.
    fn batch_count(&self, light: usize) -> usize {
        self.plan_of(light).map_or(0, |(_, plan)| plan.draw_count)
    }
}
