//! Bind groups of one view. They are kept as long as their resources stay the same.

use bevy::render::render_resource::{
    BindGroup, BindGroupEntries, BufferBinding, BufferId, IntoBinding, PipelineCache, TextureView,
    TextureViewId,
};
use bevy::render::renderer::RenderDevice;

use super::pipelines::AntumbraPipelines;
use super::view_state::{LightDraw, ViewState};
use crate::render::gpu::bind_groups::bind_in_order;
use crate::render::gpu::kept::Kept;

/// Bind groups 2 and 3 of a view's draws. They are lost with the device, like the view's buffers.
#[derive(Debug, Default)]
pub struct ViewGroups {
    base: Kept<(BufferId, BufferId, TextureViewId), BindGroup>,
    light: Kept<(BufferId, TextureViewId), BindGroup>,
    mask: Kept<wgpu::TextureView, wgpu::BindGroup>,
    masks: Kept<[wgpu::TextureView; 3], wgpu::BindGroup>,
}

impl ViewGroups {
    /// Returns the number of groups made so far. It does not grow in a steady frame.
    pub fn made(&self) -> usize {
        self.base.made + self.light.made + self.mask.made + self.masks.made
    }

    /// Returns group 2 of the base draw and group 2 of the lights; `None` before the view's buffers are
    /// written. The texture `pass_id` holds, for each pixel, Bevy's id of the deferred pass that lights it.
    pub(super) fn own(
        &mut self,
        device: &RenderDevice,
        cache: &PipelineCache,
        pipelines: &AntumbraPipelines,
        view: &ViewState,
        pass_id: &TextureView,
    ) -> Option<(BindGroup, BindGroup)> {
        let (managed, bits, lights) = (view.managed.buffer()?, view.bits.buffer()?, view.lights.buffer()?);
        let base = self.base.get((managed.id(), bits.id(), pass_id.id()), || {
            device.create_bind_group(
                "antumbra base",
                &cache.get_bind_group_layout(&pipelines.base_layout),
                &BindGroupEntries::sequential((
                    managed.as_entire_binding(),
                    bits.as_entire_binding(),
                    pass_id,
                )),
            )
        });
        let light = self.light.get((lights.id(), pass_id.id()), || {
            let draw = BufferBinding {
                buffer: lights,
                offset: 0,
                size: std::num::NonZero::new(size_of::<LightDraw>() as u64),
            };
            device.create_bind_group(
                "antumbra light",
                &cache.get_bind_group_layout(&pipelines.light_layout),
                &BindGroupEntries::sequential((draw.into_binding(), pass_id)),
            )
        });
        Some((base.clone(), light.clone()))
    }

    /// Returns group 3 of lights whose terms are weighted: the mask, the factors of light functions, and the weights of
    /// surfaces.
    pub(super) fn masks(
        &mut self,
        device: &RenderDevice,
        cache: &PipelineCache,
        pipelines: &AntumbraPipelines,
        views: [&wgpu::TextureView; 3],
    ) -> &wgpu::BindGroup {
        self.masks.get(views.map(Clone::clone), || {
            let layout = cache.get_bind_group_layout(&pipelines.masks_layout);
            let views = views.map(wgpu::BindingResource::TextureView);
            bind_in_order(device.wgpu_device(), "antumbra masks", &layout, views)
        })
    }

    /// Returns group 3 of lights with a mask. The lights of a frame share one mask.
    pub(super) fn mask(
        &mut self,
        device: &RenderDevice,
        cache: &PipelineCache,
        pipelines: &AntumbraPipelines,
        mask: &wgpu::TextureView,
    ) -> &wgpu::BindGroup {
        self.mask.get(mask.clone(), || {
            let layout = cache.get_bind_group_layout(&pipelines.mask_layout);
            bind_in_order(
                device.wgpu_device(),
                "antumbra mask",
                &layout,
                [wgpu::BindingResource::TextureView(mask)],
            )
        })
    }
}
