//! Writes what a view's shaders know of each light that this crate lights it with.

use bevy::camera::visibility::RenderLayers;
use bevy::color::ColorToComponents;
use bevy::ecs::prelude::*;
use bevy::pbr::{
    ExtractedDirectionalLight, ExtractedRectLight, GlobalClusterableObjectMeta, MAX_DIRECTIONAL_LIGHTS,
    MAX_RECT_LIGHTS, MeshPipelineKey,
};
use bevy::render::render_resource::BufferUsages;
use bevy::render::sync_world::MainEntity;
use bytemuck::Zeroable;
use glam::{Vec3, Vec4};

use super::draw_resources::DrawnWith;
use super::forward_masks::{DARK_LAYER, MAX_KEPT};
use super::light_convert::BevyLight;
use super::mirror::{HostLight, Mirror};
use super::pipelines::{LightPipelines, VisibilitySource, is_ready};
use super::view_state::{DrawSlot, LightDraw, Managed, Unindexed};
use crate::render::Renderer;
use crate::sets::{FrameLight, FrameLights, Objects, VisibleSet};

type Directional<'a> = (Entity, &'a ExtractedDirectionalLight, &'a RenderLayers);

/// The components that Bevy queries rectangles by. It shows the first few in the order of this query.
type Rect<'a> = (Entity, &'a MainEntity, &'a ExtractedRectLight, &'a RenderLayers);

/// Bevy's data from which its shaders identify lights.
pub(super) type BevyLights<'w, 's> = (
    Res<'w, GlobalClusterableObjectMeta>,
    Query<'w, 's, Directional<'static>>,
    Query<'w, 's, Rect<'static>>,
);

/// Lists the managed lights of the frame in the form in which Bevy's shaders know them. A light whose
/// pipelines or index are not ready yet is left to Bevy.
pub(super) fn prepare_lights(
    mirror: &mut Mirror,
    key: MeshPipelineKey,
    depth_stencil: wgpu::TextureFormat,
    gpu: &mut DrawnWith,
    lights: &BevyLights,
) {
    let Mirror {
        world, view, layers, ..
    } = mirror;
    let frame = world.resource::<FrameLights>();
    let (objects, visible) = (world.resource::<Objects>(), world.resource::<VisibleSet>());
    view.unshadowed_in_view = visible.set.difference(&objects.receivers).next().is_some();
    let renderer = world.resource::<Renderer>();
    let mut managed = Managed::zeroed();
    let mut kept = 0;
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
            let mut draw = with_model(describe(&host, layers, lights)?, light);
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
            let layer = match active {
                _ if !view.keeps_masks => None,
                None => Some(DARK_LAYER),
                Some(_) => (kept < MAX_KEPT).then_some(DARK_LAYER + 1 + kept),
            };
            let lists = (&mut view.bit_words, &mut view.layer_words);
            if !manage(&mut managed, lists, host.kind, &draw, layer) {
                return None;
            }
            kept += u32::from(active.is_some() && layer.is_some());
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
        let (device, queue, usage) = (gpu.device, gpu.queue, BufferUsages::STORAGE);
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
    let (device, queue) = (gpu.device, gpu.queue);
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

/// Returns the data by which Bevy's shaders know a light; `None` if Bevy does not show the light in a view of these layers,
/// because it has not extracted the light or shows a limited number.
fn describe(
    host: &HostLight,
    layers: &RenderLayers,
    (clustered, directional, rect): &BevyLights,
) -> Option<LightDraw> {
    let mut draw = LightDraw::default();
    match host.kind {
        BevyLight::Point | BevyLight::Spot => {
            let index = *clustered.entity_to_index.get(&host.render_entity)?;
            draw.index[0] = u32::try_from(index).ok()?;
        }
        // These are the expressions by which Bevy fills its uniforms, so the shader finds the same bits.
        BevyLight::Directional => {
            let (entity, light, _) = directional.get(host.render_entity).ok()?;
            let order = |entity: Entity, light: &ExtractedDirectionalLight| {
                (light.volumetric, light.shadow_maps_enabled, entity) // as Bevy has it
            };
            let is_before = |(other, other_light, other_layers): &Directional| {
                other_layers.intersects(layers) && order(*other, other_light) < order(entity, light)
            };
            if directional.iter().filter(is_before).count() >= MAX_DIRECTIONAL_LIGHTS {
                return None;
            }
            let color = Vec4::from_slice(&light.color.to_f32_array()) * light.illuminance;
            let towards: Vec3 = light.transform.back().into();
            draw.unindexed = unindexed(color, towards);
        }
        BevyLight::Rect => {
            let mut shown = rect.iter().take(MAX_RECT_LIGHTS);
            let (_, _, light, _) = shown.find(|(entity, ..)| *entity == host.render_entity)?;
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
            .light(gpu.cache, gpu.bevy, key, kind, visibility, depth_stencil);
        ready &= is_ready(gpu.cache, id);
        Some(id)
    });
    ready.then_some(LightPipelines(ids))
}
