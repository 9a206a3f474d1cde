//! The state with which the GPU draws a mirror's lights: the managed lights, and the uniforms of each light.

use std::sync::Mutex;

use bevy::pbr::{MAX_DIRECTIONAL_LIGHTS, MAX_RECT_LIGHTS};
use bevy::render::render_resource::{Buffer, BufferDescriptor, BufferUsages};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bytemuck::{Pod, Zeroable};

use super::forward_masks::ForwardMasks;
use super::pipelines::LightPipelines;
use super::view_groups::ViewGroups;
use crate::render::RenderError;
use crate::render::gpu::strided::Strided;

/// A light without an index from Bevy, identified by the values that Bevy uploads for it. WGSL mirror:
/// `Unindexed` in `shaders/bevy/base.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Unindexed {
    /// Colour as Bevy uploads it: linear RGBA times lux or lumens.
    pub color: [f32; 4],
    /// Unit direction towards a directional light, or position of a rectangle's centre, world space. In lists of
    /// lights, w is 1 more than the layer with the light's visibility; it is 0 if there is no layer.
    pub place: [f32; 4],
    /// Unit vector to the right of a rectangle, world space; w: its width, metres. 0 for directional lights.
    pub right: [f32; 4],
    /// Unit vector to the top of a rectangle, world space; w: its height, metres. 0 for directional lights.
    pub up: [f32; 4],
}

/// The managed lights of a view, which the base draw leaves out. WGSL mirror: `Managed` in
/// `shaders/bevy/base.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Managed {
    /// Number of directional lights in x, of rectangles in y, and of words with bits of point and spot lights
    /// in z.
    pub counts: [u32; 4],
    /// Managed directional lights; `counts` says how many.
    pub directional: [Unindexed; MAX_DIRECTIONAL_LIGHTS],
    /// Managed rectangle lights; `counts` says how many.
    pub rect: [Unindexed; MAX_RECT_LIGHTS],
}

/// Uniforms of the draw of one light. WGSL mirror: `LightDraw` in `shaders/bevy/light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightDraw {
    /// Values that identify a directional or rectangle light, which has no index.
    pub unindexed: Unindexed,
    /// Bevy's index of a point or spot light in x; in y 1 if surfaces have weights of their own.
    pub index: [u32; 4],
    /// Weights of ambient, diffuse and specular light; w: darkness of shadows.
    pub weights: [f32; 4],
    /// Colour of shadows, linear RGB, for a light whose largest component is 1; w unused.
    pub shadow: [f32; 4],
}

// These are the sizes in the shaders. Naga cannot read those shaders without Bevy's, so no test compares the
// structs. `tests/bevy/shading.rs` would show a difference in the picture.
const _: () = assert!(size_of::<Managed>() == 16 + (10 + 8) * 64 && size_of::<LightDraw>() == 112);

/// The uniforms and pipelines with which a light of the frame is drawn.
#[derive(Clone, Copy, Debug)]
pub struct DrawSlot {
    /// Offset in bytes of the light's [`LightDraw`] in [`ViewState::lights`].
    pub offset: u32,
    /// Pipelines of the light's kind.
    pub pipelines: LightPipelines,
    /// Layer with the light's visibility for forward meshes, if they read it and there is room.
    pub layer: Option<u32>,
}

/// A buffer that grows, and is written only when its content changed.
#[derive(Debug, Default)]
pub struct Uploaded {
    buffer: Option<Buffer>,
    bytes: Vec<u8>,
}

impl Uploaded {
    /// Makes the buffer hold these bytes. Returns `true` if a new buffer was made.
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

    /// Returns the buffer; `None` before the first write.
    pub fn buffer(&self) -> Option<&Buffer> {
        self.buffer.as_ref()
    }
}

/// The state with which the GPU draws a mirror's lights.
#[derive(Debug, Default)]
pub struct ViewState {
    /// Draws of the frame's lights, in the order of [`FrameLights`](crate::sets::FrameLights). A light with
    /// `None` is left to Bevy.
    pub draws: Vec<Option<DrawSlot>>,
    /// Buffer with the view's [`Managed`] lights.
    pub managed: Uploaded,
    /// Buffer with one bit for each point and spot light, by Bevy's index. The bit is set if the light is
    /// managed.
    pub bits: Uploaded,
    /// Buffer with the lights' [`LightDraw`]s at dynamic offsets.
    pub lights: Uploaded,
    /// The managed lights as forward meshes read them, with layers.
    pub forward_managed: Uploaded,
    /// For each point and spot light, by Bevy's index: 1 more than the layer with its visibility, or 0.
    pub forward_layers: Uploaded,
    /// The masks that forward meshes read.
    pub forward: ForwardMasks,
    /// Whether the view keeps its lights' visibility in this frame.
    pub keeps_masks: bool,
    /// Number of managed lights that light something in view and whose visibility the view cannot keep, because
    /// there are too many.
    pub unkept_lights: u32,
    /// Bind groups of the view. They are made while the view is drawn; the mutex allows this although the
    /// mirror is only read then.
    pub groups: Mutex<ViewGroups>,
    /// The error that keeps the view from ever being drawn on this device; `None` if there is none.
    pub failed: Option<RenderError>,
    /// Whether the view is left to Bevy because it is neither perspective nor orthographic.
    pub odd_projection: bool,
    /// Whether any visible object shows no shadows.
    pub unshadowed_in_view: bool,
    /// Words of `bits`. They are kept to reuse their allocation.
    pub(super) bit_words: Vec<u32>,
    /// Contents of `lights`. They are kept to reuse their allocation.
    pub(super) light_draws: Strided<LightDraw>,
    /// Contents of `forward_layers`. They are kept to reuse their allocation.
    pub(super) layer_words: Vec<u32>,
}

impl ViewState {
    /// Records an error and leaves the view to Bevy for good.
    pub(super) fn fail<T>(&mut self, error: RenderError) -> Option<T> {
        self.failed = Some(error);
        None
    }
}
