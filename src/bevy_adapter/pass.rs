//! The light of a view. The base draw is Bevy's deferred lighting without the managed lights; then each
//! managed light is added, multiplied by its visibility.
//!
//! Shaders `shaders/bevy/base.wgsl`, `shaders/bevy/light.wgsl`
//! Reads   Bevy's G-buffer and depth prepass.  Writes  radiance
//! Order   after Bevy's deferred lighting, which such views skip; before screen-space reflections, which read
//! it

use std::sync::PoisonError;

use bevy::camera::{MainPassResolutionOverride, Viewport};
use bevy::core_pipeline::prepass::ViewPrepassTextures;
use bevy::ecs::prelude::*;
use bevy::pbr::MeshViewBindGroup;
use bevy::render::camera::ExtractedCamera;
use bevy::render::render_resource::{PipelineCache, RenderPassDescriptor};
use bevy::render::renderer::{RenderContext, ViewQuery};
use bevy::render::sync_world::MainEntity;
use bevy::render::view::ViewTarget;

use super::mirror::Mirrors;
use super::pipelines::{AntumbraPipelines, VisibilitySource};
use super::prepare::AntumbraView;
use crate::render::Renderer;
use crate::render::frame::hosted::{HostFrame, HostedLight};

/// Lights one view. `Core3d` runs this once for each marked camera, and not for Bevy's shadow views.
///
/// Set: [`Light`](super::AntumbraRenderSystems::Light).
pub(super) fn light_view(
    view: ViewQuery<(
        &MainEntity,
        &ExtractedCamera,
        &ViewTarget,
        &ViewPrepassTextures,
        &MeshViewBindGroup,
        &AntumbraView,
        Option<&MainPassResolutionOverride>,
    )>,
    mirrors: Res<Mirrors>,
    pipelines: Res<AntumbraPipelines>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (main, camera, target, prepass, bevy, antumbra, resolution) = view.into_inner();
    let (Some(mirror), Some(base)) = (mirrors.get(main.id()), cache.get_render_pipeline(antumbra.base))
    else {
        return;
    };
    let (Some(renderer), Some(depth), Some(pass_id)) = (
        mirror.world.get_resource::<Renderer>(),
        prepass.depth_view(),
        prepass.deferred_lighting_pass_id.as_ref(),
    ) else {
        return;
    };
    let pass_id = &pass_id.texture.default_view;
    let device = ctx.render_device().clone();
    // No other view uses these groups, and a panic in an earlier frame leaves them intact.
    let mut groups = mirror.view.groups.lock().unwrap_or_else(PoisonError::into_inner);
    let Some((base_group, light_group)) = groups.own(&device, &cache, &pipelines, &mirror.view, pass_id)
    else {
        return;
    };

    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("antumbra base"),
        color_attachments: &[Some(target.get_color_attachment())],
        depth_stencil_attachment: None,
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    if let Some(viewport) = Viewport::from_viewport_and_override(camera.viewport.as_ref(), resolution) {
        pass.set_camera_viewport(&viewport);
    }
    pass.set_render_pipeline(base);
    pass.set_bind_group(0, &bevy.main, &bevy.main_offsets);
    pass.set_bind_group(1, &bevy.binding_array, &[]);
    pass.set_bind_group(2, &base_group, &[]);
    pass.draw(0..3, 0..1);
    drop(pass);

    let frame = HostFrame {
        radiance: target.main_texture_view(),
        depth,
    };
    let shade = &mut |pass: &mut wgpu::RenderPass<'_>, light: &HostedLight| {
        let Some(slot) = mirror.view.draws.get(light.light).copied().flatten() else {
            return; // Bevy draws this light
        };
        let visibility = match light.mask {
            Some(_) if light.factors.is_some() => VisibilitySource::Terms,
            Some(_) if light.is_scaled => VisibilitySource::Scaled,
            Some(_) => VisibilitySource::Mask,
            None => VisibilitySource::Stencil,
        };
        pass.set_bind_group(0, &*bevy.main, &bevy.main_offsets);
        pass.set_bind_group(1, &*bevy.binding_array, &[]);
        pass.set_bind_group(2, &*light_group, &[slot.offset]);
        if let (Some(mask), Some(factors)) = (light.mask, light.factors) {
            // Without weights of surfaces the shader does not read the third texture.
            let weights = light.surface_weights.unwrap_or(factors);
            let group = groups.masks(&device, &cache, &pipelines, [mask, factors, weights]);
            pass.set_bind_group(3, group, &[]);
        } else if let Some(mask) = light.mask {
            pass.set_bind_group(3, groups.mask(&device, &cache, &pipelines, mask), &[]);
        }
        let mut draw = |visibility| {
            let id = slot.pipelines.get(visibility);
            if let Some(pipeline) = id.and_then(|id| cache.get_render_pipeline(id)) {
                pass.set_pipeline(pipeline);
                pass.draw(0..3, 0..1);
            }
        };
        draw(visibility);
        if visibility == VisibilitySource::Stencil && mirror.view.unshadowed_in_view {
            draw(VisibilitySource::Unshadowed);
        }
    };
    let layer = |light: usize| {
        let slot = mirror.view.draws.get(light).copied().flatten()?;
        mirror.view.forward.layer(slot.layer?)
    };
    let kept = mirror.view.keeps_masks.then_some(&layer as &dyn Fn(usize) -> _);
    renderer.record_hosted_keeping(ctx.command_encoder(), &frame, kept, shade);
}
