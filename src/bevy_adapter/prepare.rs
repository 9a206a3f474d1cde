//! Runs each view's frame on the CPU, and writes what the GPU needs to light the view.

use std::sync::Arc;

use bevy::camera::MainPassResolutionOverride;
use bevy::color::ColorToComponents;
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass};
use bevy::ecs::prelude::*;
use bevy::ecs::system::SystemParam;
use bevy::pbr::deferred::{DeferredLightingLayout, SkipDeferredLighting};
use bevy::pbr::{
    ExtractedDirectionalLight, ExtractedRectLight, GlobalClusterableObjectMeta, MeshPipelineKey, ViewKeyCache,
};
use bevy::render::camera::{ExtractedCamera, TemporalJitter};
use bevy::render::render_resource::{BindGroup, BufferUsages, CachedRenderPipelineId, PipelineCache};
use bevy::render::renderer::{RenderAdapterInfo, RenderDevice, RenderQueue};
use bevy::render::sync_world::MainEntity;
use bevy::render::view::ExtractedView;
use bytemuck::Zeroable;
use glam::{UVec2, Vec3, Vec4};

use super::forward_masks::{ForwardMasks, MAX_LAYERS, neutral};
use super::forward_views::{ForwardGroup, ForwardViews};
use super::light_convert::BevyLight;
use super::mirror::{HostLight, Mirror, Mirrors};
use super::pipelines::{AntumbraPipelines, LightPipelines, VisibilitySource, is_ready};
use super::projection::projection_of;
use super::surfaces::CutOutTextures;
use super::view_state::{DrawSlot, LightDraw, Managed, Unindexed, ViewState};
use crate::render::frame::hosted::HostView;
use crate::render::{Gpu, RenderContext, RenderError, Renderer};
use crate::scene::Camera;
use crate::sets::{FrameLight, FrameLights, Objects, ViewportSize, VisibleSet};

/// Marks a view that this crate lights in this frame. The component is on the view's entity in the render
/// world.
#[derive(Component, Clone, Copy, Debug)]
pub struct AntumbraView {
    /// Pipeline of the base draw.
    pub base: CachedRenderPipelineId,
}

/// The resources with which views are drawn.
#[derive(SystemParam)]
pub struct DrawnWith<'w> {
    device: Res<'w, RenderDevice>,
    queue: Res<'w, RenderQueue>,
    adapter: Res<'w, RenderAdapterInfo>,
    cache: Res<'w, PipelineCache>,
    pipelines: ResMut<'w, AntumbraPipelines>,
    bevy: Res<'w, DeferredLightingLayout>,
    keys: Res<'w, ViewKeyCache>,
}

impl DrawnWith<'_> {
    /// Returns the GPU resources that all views share. The first view makes them.
    fn resident(&mut self) -> Result<Arc<Gpu>, RenderError> {
        if let Some(gpu) = &self.pipelines.resident {
            return Ok(gpu.clone());
        }
        let mut context = RenderContext::hosted(
            self.device.wgpu_device().clone(),
            (**self.queue.0).clone(),
            format!("{} ({:?})", self.adapter.name, self.adapter.backend),
        );
        if self.adapter.device_type == wgpu::DeviceType::Cpu {
            context.anisotropy = 1;
        }
        let gpu = Arc::new(Gpu::new(context)?);
        self.pipelines.resident = Some(gpu.clone());
        Ok(gpu)
    }

    /// Returns the bind group with which forward meshes of a view read masks; `None` if the device has no room
    /// for it.
    fn forward_group(&mut self, view: &mut ViewState, is_ready: bool) -> Option<BindGroup> {
        let pipelines = &mut *self.pipelines;
        if view.keeps_masks
            && is_ready
            && let (Some(managed), Some(layers)) =
                (view.forward_managed.buffer(), view.forward_layers.buffer())
        {
            let masks = &mut view.forward;
            return masks.group(&self.device, &self.cache, pipelines, managed, layers);
        }
        if pipelines.forward_neutral.is_none() {
            pipelines.forward_neutral = neutral(&self.device, &self.cache, pipelines);
        }
        pipelines.forward_neutral.clone()
    }
}

/// Bevy's data from which its shaders identify lights.
#[derive(SystemParam)]
pub struct BevyLights<'w, 's> {
    clustered: Res<'w, GlobalClusterableObjectMeta>,
    directional: Query<'w, 's, &'static ExtractedDirectionalLight>,
    rect: Query<'w, 's, &'static ExtractedRectLight>,
}

type ViewItem<'a> = (
    Entity,
    &'a MainEntity,
    &'a ExtractedView,
    &'a ExtractedCamera,
    Option<&'a TemporalJitter>,
    Option<&'a MainPassResolutionOverride>,
    Has<DepthPrepass>,
    Has<DeferredPrepass>,
    Has<SkipDeferredLighting>,
    Has<AntumbraView>,
    Option<&'a ForwardGroup>,
);

/// Runs the frame of every marked view. As soon as everything needed to draw is ready, the view's deferred
/// lighting is taken over from Bevy.
///
/// Runs in `Render`, in `PrepareResources`. Set: [`Prepare`](super::AntumbraRenderSystems::Prepare).
pub(super) fn prepare_views(
    mut commands: Commands,
    mut mirrors: ResMut<Mirrors>,
    views: Query<ViewItem<'static>>,
    mut gpu: DrawnWith,
    lights: BevyLights,
    mut cut_outs: CutOutTextures,
    forward: Res<ForwardViews>,
) {
    if cut_outs.are_needed()
        && mirrors.iter().next().is_some()
        && let Ok(resident) = gpu.resident()
    {
        cut_outs.bind(&resident); // if this fails, each view reports it
    }
    for (view, main, extracted, camera, jitter, resolution, depth, deferred, skips, lit, group) in &views {
        let Some(mirror) = mirrors.get_mut(main.id()) else {
            if lit {
                commands
                    .entity(view)
                    .remove::<(AntumbraView, SkipDeferredLighting)>();
            }
            continue;
        };
        let key = gpu.keys.get(&extracted.retained_view_entity).copied();
        mirror.view.keeps_masks = forward.reads_masks(extracted.retained_view_entity);
        if !mirror.view.keeps_masks {
            mirror.view.forward = ForwardMasks::default(); // frees the masks of meshes that are gone
        }
        // An upscaler lets the main pass draw into a part of the viewport.
        let size = resolution.map(|size| size.0).or(camera.physical_viewport_size);
        let ready = match (key, size) {
            (Some(key), Some(size)) if camera.hdr && depth && deferred => {
                prepare_view(mirror, extracted, camera, (size, jitter), key, &mut gpu, &lights)
            }
            _ => None,
        };
        let wanted = gpu.forward_group(&mut mirror.view, ready.is_some());
        if let Some(wanted) = wanted
            && group.is_none_or(|group| group.0.id() != wanted.id())
        {
            commands.entity(view).insert(ForwardGroup(wanted));
        }
        match ready {
            Some(ready) => {
                commands.entity(view).insert(ready);
                if !skips {
                    commands.entity(view).insert(SkipDeferredLighting);
                }
            }
            None if lit => {
                commands
                    .entity(view)
                    .remove::<(AntumbraView, SkipDeferredLighting)>();
            }
            None => {}
        }
    }
}

fn prepare_view(
    mirror: &mut Mirror,
    view: &ExtractedView,
    camera: &ExtractedCamera,
    (size, jitter): (UVec2, Option<&TemporalJitter>),
    key: MeshPipelineKey,
    gpu: &mut DrawnWith,
    lights: &BevyLights,
) -> Option<AntumbraView> {
    if mirror.view.failed.is_some() {
        return None; // it would fail again
    }
    let target = camera.physical_target_size?;
    let origin = camera
        .viewport
        .as_ref()
        .map_or(UVec2::ZERO, |viewport| viewport.physical_position);
    let projection = projection_of(&view.clip_from_view, jitter, size);
    mirror.view.odd_projection = projection.is_none() && size.min_element() > 0;
    let projection = projection?;
    let base = gpu.pipelines.base(&gpu.cache, &gpu.bevy, key);

    if !mirror.world.contains_resource::<Renderer>() {
        // The renderer shares pipelines, meshes and materials with the other views.
        let made = gpu.resident().and_then(Renderer::on);
        match made {
            Ok(renderer) => mirror.world.insert_resource(renderer),
            Err(error) => return mirror.view.fail(error),
        }
    }
    let mut place = mirror.world.entity_mut(mirror.camera);
    if place.get::<Camera>() != Some(&projection.camera) {
        place.insert(projection.camera);
    }
    let world_from_camera = projection.place(&view.world_from_view);
    if place.get() != Some(&world_from_camera) {
        place.insert(world_from_camera);
    }
    mirror
        .world
        .resource_mut::<ViewportSize>()
        .set_if_neq(ViewportSize(size));
    let mut renderer = mirror.world.resource_mut::<Renderer>();
    let host = HostView {
        target_size: target,
        viewport_origin: origin,
        clip_from_view: projection.clip_from_view,
    };
    if let Err(error) = renderer.set_host(Some(host)) {
        return mirror.view.fail(error);
    }
    renderer.set_host_terms(true);
    let depth_stencil = renderer.context().depth_stencil_format();
    mirror.run();
    if mirror.world.resource::<Renderer>().failure().is_some() {
        return None; // the mirror reports it; the next frame tries again, because it may need less
    }
    if mirror.view.keeps_masks
        && let Err(error) = mirror.world.resource_mut::<Renderer>().prepare_keeping()
    {
        return mirror.view.fail(error);
    }
    prepare_lights(mirror, key, depth_stencil, gpu, lights);
    if mirror.view.keeps_masks {
        let layers = mirror
            .view
            .draws
            .iter()
            .flatten()
            .filter_map(|slot| slot.layer)
            .count();
        mirror.view.forward.resize(&gpu.device, target, layers as u32);
    }
    is_ready(&gpu.cache, base).then_some(AntumbraView { base })
}

/// Lists the managed lights of the frame in the form in which Bevy's shaders know them. A light whose
/// pipelines or index are not ready yet is left to Bevy.
fn prepare_lights(
    mirror: &mut Mirror,
    key: MeshPipelineKey,
    depth_stencil: wgpu::TextureFormat,
    gpu: &mut DrawnWith,
    lights: &BevyLights,
) {
    let Mirror { world, view, .. } = mirror;
    let frame = world.resource::<FrameLights>();
    let (objects, visible) = (world.resource::<Objects>(), world.resource::<VisibleSet>());
    view.unshadowed_in_view = visible.set.difference(&objects.receivers).next().is_some();
    let renderer = world.resource::<Renderer>();
    let mut managed = Managed::zeroed();
    let mut layers = 0;
    view.unkept_lights = 0;
    view.layer_words.clear();
    view.draws.clear();
    view.light_draws.clear();
    view.bit_words.clear();
    for (index, light) in frame.lights.iter().enumerate() {
        let drawn = &renderer.frame().lights; // in ascending order of their index
        let active = drawn.binary_search_by_key(&index, |active| active.light);
        let active = active.ok().map(|at| &drawn[at]);
        let host = world.get::<HostLight>(light.entity).copied();
        let slot = host.and_then(|host| {
            let mut draw = with_model(describe(&host, lights)?, light);
            draw.index[1] = u32::from(!renderer.frame().weighted.is_empty());
            let wanted = [
                (VisibilitySource::Stencil, true),
                (VisibilitySource::Unshadowed, view.unshadowed_in_view),
                (VisibilitySource::Mask, true),
                (
                    VisibilitySource::Scaled,
                    active.is_some_and(|active| active.is_scaled),
                ),
                (
                    VisibilitySource::Terms,
                    active.is_some_and(|active| active.is_tinted),
                ),
            ];
            let pipelines = pipelines_of(host.kind, key, depth_stencil, wanted, gpu)?;
            let layer = (view.keeps_masks && layers < MAX_LAYERS).then_some(layers);
            let lists = (&mut view.bit_words, &mut view.layer_words);
            if !manage(&mut managed, lists, host.kind, &draw, layer) {
                return None;
            }
            layers += u32::from(layer.is_some());
            view.unkept_lights += u32::from(view.keeps_masks && layer.is_none());
            let offset = view.light_draws.push(&draw);
            Some(DrawSlot {
                offset,
                pipelines,
                layer,
            })
        });
        view.draws.push(slot);
    }
    if view.keeps_masks {
        let mut managed = managed;
        managed.counts[2] = view.layer_words.len() as u32;
        view.layer_words.push(0); // bindings are never empty
        let (device, queue, usage) = (&gpu.device, &gpu.queue, BufferUsages::STORAGE);
        let bytes = bytemuck::bytes_of(&managed);
        let label = "antumbra forward lights";
        view.forward_managed.write(device, queue, label, usage, bytes);
        let bytes = bytemuck::cast_slice(&view.layer_words);
        view.forward_layers.write(device, queue, label, usage, bytes);
    }
    managed.counts[2] = view.bit_words.len() as u32;
    if view.bit_words.is_empty() {
        view.bit_words.push(0); // bindings are never empty
    }
    if view.light_draws.bytes().is_empty() {
        view.light_draws.push(&LightDraw::default());
    }
    let (device, queue) = (&gpu.device, &gpu.queue);
    let (storage, uniform) = (BufferUsages::STORAGE, BufferUsages::UNIFORM);
    let bits = bytemuck::cast_slice(&view.bit_words);
    view.managed.write(
        device,
        queue,
        "antumbra managed",
        storage,
        bytemuck::bytes_of(&managed),
    );
    view.bits
        .write(device, queue, "antumbra managed bits", storage, bits);
    view.lights.write(
        device,
        queue,
        "antumbra lights",
        uniform,
        view.light_draws.bytes(),
    );
}

/// Adds the terms of a light's model. Bevy's uniforms hold the light's colour times its brightness, so the colour of
/// the shadow is given for a light whose largest component is 1.
fn with_model(mut draw: LightDraw, light: &FrameLight) -> LightDraw {
    let largest = light.light.color.max_element();
    draw.weights = light
        .model
        .weights
        .to_vec3()
        .extend(light.model.tint.darkness)
        .to_array();
    if largest > 0.0 {
        draw.shadow = (light.model.tint.color / largest).extend(0.0).to_array();
    }
    draw
}

/// Returns the data by which Bevy's shaders know a light; `None` if Bevy has not extracted the light.
fn describe(host: &HostLight, lights: &BevyLights) -> Option<LightDraw> {
    let mut draw = LightDraw::default();
    match host.kind {
        BevyLight::Point | BevyLight::Spot => {
            let index = *lights.clustered.entity_to_index.get(&host.render_entity)?;
            draw.index[0] = u32::try_from(index).ok()?;
        }
        // These are the expressions by which Bevy fills its uniforms, so the shader finds the same bits.
        BevyLight::Directional => {
            let light = lights.directional.get(host.render_entity).ok()?;
            let color = Vec4::from_slice(&light.color.to_f32_array()) * light.illuminance;
            let towards: Vec3 = light.transform.back().into();
            draw.unindexed = unindexed(color, towards);
        }
        BevyLight::Rect => {
            let light = lights.rect.get(host.render_entity).ok()?;
            let color = Vec4::from_slice(&light.color.to_f32_array()) * light.intensity;
            draw.unindexed = unindexed(color, light.transform.translation());
            let (right, up): (Vec3, Vec3) = (light.transform.right().into(), light.transform.up().into());
            draw.unindexed.right = right.extend(light.width).to_array();
            draw.unindexed.up = up.extend(light.height).to_array();
        }
    }
    Some(draw)
}

fn unindexed(color: Vec4, place: Vec3) -> Unindexed {
    Unindexed {
        color: color.to_array(),
        place: place.extend(0.0).to_array(),
        ..Default::default()
    }
}

/// Lists a light as managed, so that the base draw leaves it out, and forward meshes find its visibility in a
/// layer. Returns `false` if there is no room for it.
fn manage(
    managed: &mut Managed,
    (bits, layers): (&mut Vec<u32>, &mut Vec<u32>),
    kind: BevyLight,
    draw: &LightDraw,
    layer: Option<u32>,
) -> bool {
    let layer = layer.map_or(0, |layer| layer + 1);
    let Managed {
        counts,
        directional,
        rect,
    } = managed;
    let (list, count): (&mut [Unindexed], _) = match kind {
        BevyLight::Directional => (directional, &mut counts[0]),
        BevyLight::Rect => (rect, &mut counts[1]),
        BevyLight::Point | BevyLight::Spot => {
            let word = (draw.index[0] / 32) as usize;
            if bits.len() <= word {
                bits.resize(word + 1, 0);
            }
            bits[word] |= 1 << (draw.index[0] % 32);
            let index = draw.index[0] as usize;
            if layers.len() <= index {
                layers.resize(index + 1, 0);
            }
            layers[index] = layer;
            return true;
        }
    };
    let Some(slot) = list.get_mut(*count as usize) else {
        return false;
    };
    *slot = draw.unindexed;
    slot.place[3] = layer as f32;
    *count += 1;
    true
}

/// Returns the wanted pipelines of a kind of light, indexed by [`VisibilitySource`]; `None` until all are
/// compiled.
fn pipelines_of(
    kind: BevyLight,
    key: MeshPipelineKey,
    depth_stencil: wgpu::TextureFormat,
    wanted: [(VisibilitySource, bool); 5],
    gpu: &mut DrawnWith,
) -> Option<LightPipelines> {
    let mut ready = true;
    let ids = wanted.map(|(visibility, is_wanted)| {
        if !is_wanted {
            return None;
        }
        let id = gpu
            .pipelines
            .light(&gpu.cache, &gpu.bevy, key, kind, visibility, depth_stencil);
        ready &= is_ready(&gpu.cache, id);
        Some(id)
    });
    ready.then_some(LightPipelines(ids))
}
