//! What of a mirror the GPU draws with: which lights are managed, and each light as the shader takes it.

use std::sync::Mutex;

use bevy::pbr::{MAX_DIRECTIONAL_LIGHTS, MAX_RECT_LIGHTS};
use bevy::render::render_resource::{Buffer, BufferDescriptor, BufferUsages};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bytemuck::{Pod, Zeroable};

use super::pipelines::LightPipelines;
use super::view_groups::ViewGroups;
use crate::render::RenderError;
use crate::render::gpu::strided::Strided;

/// A light that Bevy gives no index that we can see, told by what Bevy uploads of it. Mirror: `Unindexed` of
/// `shaders/bevy/base.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Unindexed {
    /// As Bevy uploads it: linear RGBA times lux or lumens.
    pub color: [f32; 4],
    /// Unit direction to a directional light, or position of a rectangle's centre; w is 0.
    pub place: [f32; 4],
}

/// Mirror: `Managed` of `shaders/bevy/base.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Managed {
    /// Directional lights, rectangles, words of the bits.
    pub counts: [u32; 4],
    /// The directional lights.
    pub directional: [Unindexed; MAX_DIRECTIONAL_LIGHTS],
    /// The rectangles.
    pub rect: [Unindexed; MAX_RECT_LIGHTS],
}

/// Mirror: `LightDraw` of `shaders/bevy/light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightDraw {
    /// Of a light without an index.
    pub unindexed: Unindexed,
    /// x: Bevy's index of a point or spot light.
    pub index: [u32; 4],
}

// As the shaders have them; naga cannot read those without Bevy's. `tests/bevy/shading.rs` would see a difference.
const _: () = assert!(size_of::<Managed>() == 16 + (10 + 8) * 32 && size_of::<LightDraw>() == 48);

/// How a light of the frame is drawn.
#[derive(Clone, Copy, Debug)]
pub struct DrawSlot {
    /// Where its [`LightDraw`] is, bytes.
    pub offset: u32,
    /// Pipelines of its kind.
    pub pipelines: LightPipelines,
}

/// A buffer that grows, and is written only when its content changed.
#[derive(Debug, Default)]
pub struct Uploaded {
    buffer: Option<Buffer>,
    bytes: Vec<u8>,
}

impl Uploaded {
    /// Makes the buffer hold these bytes; `true` if it is another buffer than before.
    pub fn write(
        &mut self,
        device: &RenderDevice,
        queue: &RenderQueue,
        label: &'static str,
        usage: BufferUsages,
        bytes: &[u8],
    ) -> bool {
        let fits = |buffer: &Buffer| buffer.size() >= bytes.len() as u64;
        let grown = !self.buffer.as_ref().is_some_and(fits);
        if grown {
            self.buffer = Some(device.create_buffer(&BufferDescriptor {
                label: Some(label),
                size: bytes.len().next_power_of_two().max(64) as u64,
                usage: usage | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }));
        }
        if (grown || self.bytes != bytes)
            && let Some(buffer) = &self.buffer
        {
            self.bytes.clear();
            self.bytes.extend_from_slice(bytes);
            queue.write_buffer(buffer, 0, bytes);
        }
        grown
    }

    /// The buffer, once written.
    pub fn buffer(&self) -> Option<&Buffer> {
        self.buffer.as_ref()
    }
}

/// What of a mirror the GPU draws with.
#[derive(Debug, Default)]
pub struct ViewState {
    /// How each light of the frame is drawn, by the order of [`FrameLights`](crate::sets::FrameLights); `None`: it is
    /// left to Bevy.
    pub draws: Vec<Option<DrawSlot>>,
    /// [`Managed`].
    pub managed: Uploaded,
    /// A bit for each point and spot light, by Bevy's index.
    pub bits: Uploaded,
    /// [`LightDraw`]s at dynamic offsets.
    pub lights: Uploaded,
    /// Written where the view is drawn, which only reads the mirror.
    pub groups: Mutex<ViewGroups>,
    /// Why it cannot be drawn, and never will be on this device.
    pub failed: Option<RenderError>,
    /// Whether the view is left to Bevy because it is neither perspective nor orthographic.
    pub odd_projection: bool,
    /// Whether objects are in view that show no shadows.
    pub unshadowed_in_view: bool,
    /// Kept for their allocations.
    pub(super) bit_words: Vec<u32>,
    pub(super) light_draws: Strided<LightDraw>,
}

impl ViewState {
    /// Gives the view up for good, and leaves it to Bevy.
    pub(super) fn fail<T>(&mut self, error: RenderError) -> Option<T> {
        self.failed = Some(error);
        None
    }
}
