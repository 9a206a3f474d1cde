//! The light of a view: Bevy's own less the managed lights, then each managed light times its visibility.
//!
//! Shaders `shaders/bevy/base.wgsl`, `shaders/bevy/light.wgsl`
//! Reads   Bevy's G-buffer and depth prepass.  Writes  radiance
//! Order   after Bevy's deferred lighting (skipped for such views), before screen-space reflections, which read it

use bevy::core_pipeline::prepass::ViewPrepassTextures;
use bevy::ecs::prelude::*;
use bevy::pbr::MeshViewBindGroup;
use bevy::render::camera::ExtractedCamera;
use bevy::render::render_resource::{
    BindGroup, BindGroupEntries, BufferBinding, IntoBinding, PipelineCache, RenderPassDescriptor,
};
use bevy::render::renderer::{RenderContext, RenderDevice, ViewQuery};
use bevy::render::sync_world::MainEntity;
use bevy::render::view::ViewTarget;

use super::mirror::Mirrors;
use super::pipelines::{AntumbraPipelines, Visibility};
use super::prepare::AntumbraView;
use super::view_state::{LightDraw, ViewState};
use crate::render::Renderer;
use crate::render::hosted::{HostFrame, HostedLight, HostedVisibility};

/// Lights one view. `Core3d` runs this once for each marked camera, and not for Bevy's shadow views.
///
/// [`Light`](super::AntumbraRenderSystems::Light).
pub(super) fn light_view(
    view: ViewQuery<(
        &MainEntity,
        &ExtractedCamera,
        &ViewTarget,
        &ViewPrepassTextures,
        &MeshViewBindGroup,
        &AntumbraView,
    )>,
    mirrors: Res<Mirrors>,
    pipelines: Res<AntumbraPipelines>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (main, camera, target, prepass, bevy, antumbra) = view.into_inner();
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
    let Some((base_group, light_group)) = own_groups(&device, &cache, &pipelines, &mirror.view, pass_id)
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
    if let Some(viewport) = &camera.viewport {
        pass.set_camera_viewport(viewport);
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
    let mut mask_group: Option<(wgpu::TextureView, wgpu::BindGroup)> = None;
    let shade = &mut |pass: &mut wgpu::RenderPass<'_>, light: &HostedLight| {
        let Some(slot) = mirror.view.draws.get(light.light).copied().flatten() else {
            return; // left to Bevy
        };
        let visibility = match light.visibility {
            HostedVisibility::Lit => Visibility::Lit,
            HostedVisibility::Stencil => Visibility::Stencil,
            HostedVisibility::Mask(_) => Visibility::Mask,
        };
        pass.set_bind_group(0, &*bevy.main, &bevy.main_offsets);
        pass.set_bind_group(1, &*bevy.binding_array, &[]);
        pass.set_bind_group(2, &*light_group, &[slot.offset]);
        if let HostedVisibility::Mask(mask) = light.visibility {
            // The lights of a frame share one mask.
            if mask_group.as_ref().is_none_or(|(known, _)| known != mask) {
                let layout = cache.get_bind_group_layout(&pipelines.mask_layout);
                let group = device
                    .wgpu_device()
                    .create_bind_group(&wgpu::BindGroupDescriptor {
                        label: Some("antumbra mask"),
                        layout: &layout,
                        entries: &[wgpu::BindGroupEntry {
                            binding: 0,
                            resource: wgpu::BindingResource::TextureView(mask),
                        }],
                    });
                mask_group = Some((mask.clone(), group));
            }
            pass.set_bind_group(3, mask_group.as_ref().map(|(_, group)| group), &[]);
        }
        let mut draw = |visibility| {
            let id = slot.pipelines.get(visibility);
            if let Some(pipeline) = id.and_then(|id| cache.get_render_pipeline(id)) {
                pass.set_pipeline(pipeline);
                pass.draw(0..3, 0..1);
            }
        };
        draw(visibility);
        if visibility == Visibility::Stencil && mirror.view.unshadowed_in_view {
            draw(Visibility::Unshadowed);
        }
    };
    renderer.record_hosted(ctx.command_encoder(), &frame, shade);
}

/// Group 2 of the base draw and of the lights.
fn own_groups(
    device: &RenderDevice,
    cache: &PipelineCache,
    pipelines: &AntumbraPipelines,
    view: &ViewState,
    pass_id: &bevy::render::render_resource::TextureView,
) -> Option<(BindGroup, BindGroup)> {
    let (managed, bits, lights) = (view.managed.buffer()?, view.bits.buffer()?, view.lights.buffer()?);
    let base = device.create_bind_group(
        "antumbra base",
        &cache.get_bind_group_layout(&pipelines.base_layout),
        &BindGroupEntries::sequential((managed.as_entire_binding(), bits.as_entire_binding(), pass_id)),
    );
    let draw = BufferBinding {
        buffer: lights,
        offset: 0,
        size: std::num::NonZero::new(size_of::<LightDraw>() as u64),
    };
    let light = device.create_bind_group(
        "antumbra light",
        &cache.get_bind_group_layout(&pipelines.light_layout),
        &BindGroupEntries::sequential((draw.into_binding(), pass_id)),
    );
    Some((base, light))
}
