//! The device and the pipelines, Bevy's and our own, that draw the views.

use std::sync::Arc;

use bevy::ecs::prelude::*;
use bevy::pbr::ViewKeyCache;
use bevy::pbr::deferred::DeferredLightingLayout;
use bevy::render::render_resource::{BindGroup, PipelineCache};
use bevy::render::renderer::{RenderAdapterInfo, RenderDevice, RenderQueue};

use super::forward_masks::neutral;
use super::pipelines::AntumbraPipelines;
use super::view_state::ViewState;
use crate::render::{Gpu, RenderContext, RenderError};

/// The resources with which views are drawn, in the order of [`DrawnWith`].
pub(super) type DrawResources<'w> = (
    Res<'w, RenderDevice>,
    Res<'w, RenderQueue>,
    Res<'w, RenderAdapterInfo>,
    Res<'w, PipelineCache>,
    ResMut<'w, AntumbraPipelines>,
    Res<'w, DeferredLightingLayout>,
    Res<'w, ViewKeyCache>,
);

/// The device and the pipelines that draw the views.
pub(super) struct DrawnWith<'a> {
    pub device: &'a RenderDevice,
    pub queue: &'a RenderQueue,
    adapter: &'a RenderAdapterInfo,
    pub cache: &'a PipelineCache,
    pub pipelines: &'a mut AntumbraPipelines,
    pub bevy: &'a DeferredLightingLayout,
    pub keys: &'a ViewKeyCache,
}

impl<'a> DrawnWith<'a> {
    pub fn of(resources: &'a mut DrawResources) -> Self {
        let (device, queue, adapter, cache, pipelines, bevy, keys) = resources;
        Self {
            device,
            queue,
            adapter,
            cache,
            pipelines,
            bevy,
            keys,
        }
    }

    /// Returns the GPU resources that all views share. The first view makes them.
    pub fn resident(&mut self) -> Result<Arc<Gpu>, RenderError> {
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
    pub fn forward_group(&mut self, view: &mut ViewState, is_ready: bool) -> Option<BindGroup> {
        let pipelines = &mut *self.pipelines;
        pipelines.forward_layout.as_ref()?;
        if view.keeps_masks
            && is_ready
            && let (Some(managed), Some(layers)) =
                (view.forward_managed.buffer(), view.forward_layers.buffer())
        {
            let masks = &mut view.forward;
            return masks.group(self.device, self.cache, pipelines, managed, layers);
        }
        if pipelines.forward_neutral.is_none() {
            pipelines.forward_neutral = neutral(self.device, self.cache, pipelines);
        }
        pipelines.forward_neutral.clone()
    }
}
