//! Runs each view's frame on the CPU, and writes what the GPU needs to light the view.

use bevy::camera::MainPassResolutionOverride;
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass};
use bevy::ecs::prelude::*;
use bevy::pbr::MeshPipelineKey;
use bevy::pbr::deferred::SkipDeferredLighting;
use bevy::render::camera::{ExtractedCamera, TemporalJitter};
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::CachedRenderPipelineId;
use bevy::render::sync_world::MainEntity;
use bevy::render::texture::GpuImage;
use bevy::render::view::ExtractedView;
use glam::UVec2;

use super::draw_resources::{DrawResources, DrawnWith};
use super::forward_masks::{DARK_LAYER, ForwardMasks};
use super::forward_views::{ForwardGroup, ForwardViews};
use super::mirror::{Mirror, Mirrors};
use super::pipelines::is_ready;
use super::prepare_lights::{BevyLights, prepare_lights};
use super::projection::projection_of;
use super::surfaces::Surfaces;
use crate::render::Renderer;
use crate::render::frame::hosted::HostView;
use crate::scene::Camera;
use crate::sets::ViewportSize;

/// Marks a view that this crate lights in this frame. The component is on the view's entity in the render
/// world.
#[derive(Component, Clone, Copy, Debug)]
pub struct AntumbraView {
    /// Pipeline of the base draw.
    pub base: CachedRenderPipelineId,
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
    mut gpu: DrawResources,
    lights: BevyLights,
    (mut surfaces, images): (ResMut<Surfaces>, Res<RenderAssets<GpuImage>>),
    forward: Res<ForwardViews>,
    grouped: Query<(Entity, &MainEntity), With<ForwardGroup>>,
) {
    // Also of cameras that are not active, which are not among the views. The group would keep the masks.
    for (view, _) in grouped
        .iter()
        .filter(|(_, main)| mirrors.get(main.id()).is_none())
    {
        commands.entity(view).remove::<ForwardGroup>();
    }
    let mut gpu = DrawnWith::of(&mut gpu);
    if !surfaces.cut_outs.is_empty()
        && mirrors.iter().next().is_some()
        && let Ok(resident) = gpu.resident()
    {
        surfaces.bind_cut_outs(&images, &resident); // if this fails, each view reports it
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
    let base = gpu.pipelines.base(gpu.cache, gpu.bevy, key);

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
        let layers = mirror.view.draws.iter().flatten().filter_map(|slot| slot.layer);
        let kept = layers.max().unwrap_or(DARK_LAYER);
        mirror.view.forward.resize(gpu.device, target, kept);
    }
    is_ready(gpu.cache, base).then_some(AntumbraView { base })
}
