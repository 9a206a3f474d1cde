//! The visibility of a view's managed lights, kept in the layers of an array for forward meshes.

use bevy::render::render_resource::{
    BindGroup, BindGroupEntries, Buffer, BufferId, BufferInitDescriptor, BufferUsages, Extent3d,
    PipelineCache, TextureDescriptor, TextureDimension, TextureUsages, TextureView, TextureViewDescriptor,
    TextureViewDimension, TextureViewId,
};
use bevy::render::renderer::RenderDevice;
use bytemuck::Zeroable;
use glam::UVec2;

use super::pipelines::AntumbraPipelines;
use super::view_state::Managed;
use crate::render::gpu::kept::Kept;
use crate::render::nodes::keep_visibility::KEPT_FORMAT;

/// Largest number of lights whose visibility a view keeps. Each takes four bytes a pixel. Beyond it, forward
/// meshes show no shadows of further lights. Lights that light nothing in view do not count.
pub const MAX_KEPT: u32 = 16;

/// The layer of lights that light nothing in view. It is never written, so it holds 0. The layers after it are those
/// of the other lights.
pub const DARK_LAYER: u32 = 0;

/// An array of masks: a view of the whole, and one of each layer.
#[derive(Debug)]
struct Masks {
    size: UVec2,
    array: TextureView,
    layers: Vec<TextureView>,
}

/// The masks of one view, and the bind group with which forward meshes read them.
#[derive(Debug, Default)]
pub struct ForwardMasks {
    masks: Option<Masks>,
    group: Kept<(BufferId, BufferId, TextureViewId), BindGroup>,
}

impl ForwardMasks {
    /// Makes room for the masks of so many lights, and for [`DARK_LAYER`].
    pub(super) fn resize(&mut self, device: &RenderDevice, size: UVec2, lights: u32) {
        let lights = lights.clamp(1, MAX_KEPT);
        let fits = |masks: &Masks| masks.size == size && masks.layers.len() > lights as usize;
        if !self.masks.as_ref().is_some_and(fits) {
            self.masks = Some(make(device, size, lights.next_power_of_two() + 1));
        }
    }

    /// Returns the mask in a layer.
    pub(super) fn layer(&self, layer: u32) -> Option<&wgpu::TextureView> {
        let view = self.masks.as_ref()?.layers.get(layer as usize)?;
        Some(view)
    }

    /// Returns the bind group with which meshes read the masks; `None` before there are any.
    pub(super) fn group(
        &mut self,
        device: &RenderDevice,
        cache: &PipelineCache,
        pipelines: &AntumbraPipelines,
        managed: &Buffer,
        layers: &Buffer,
    ) -> Option<BindGroup> {
        let array = &self.masks.as_ref()?.array;
        let layout = pipelines.forward_layout.as_ref()?;
        let group = self.group.get((managed.id(), layers.id(), array.id()), || {
            device.create_bind_group(
                "antumbra forward masks",
                &cache.get_bind_group_layout(layout),
                &BindGroupEntries::sequential((
                    managed.as_entire_binding(),
                    layers.as_entire_binding(),
                    array,
                )),
            )
        });
        Some(group.clone())
    }
}

/// Returns a bind group without lights, for views that are not ready.
pub(super) fn neutral(
    device: &RenderDevice,
    cache: &PipelineCache,
    pipelines: &AntumbraPipelines,
) -> Option<BindGroup> {
    let buffer = |contents: &[u8]| {
        device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("antumbra no lights"),
            contents,
            usage: BufferUsages::STORAGE,
        })
    };
    let managed = buffer(bytemuck::bytes_of(&Managed::zeroed()));
    let layers = buffer(&[0; 4]);
    let mut masks = ForwardMasks::default();
    masks.resize(device, UVec2::ONE, 1);
    masks.group(device, cache, pipelines, &managed, &layers)
}

fn make(device: &RenderDevice, size: UVec2, count: u32) -> Masks {
    let texture = device.create_texture(&TextureDescriptor {
        label: Some("antumbra forward masks"),
        size: Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: count,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format: KEPT_FORMAT,
        usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let view = |dimension, first, layers| {
        texture.create_view(&TextureViewDescriptor {
            dimension: Some(dimension),
            base_array_layer: first,
            array_layer_count: Some(layers),
            ..Default::default()
        })
    };
    Masks {
        size,
        array: view(TextureViewDimension::D2Array, 0, count),
        layers: (0..count)
            .map(|layer| view(TextureViewDimension::D2, layer, 1))
            .collect(),
    }
}
