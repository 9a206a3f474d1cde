//! The buffers of a frame's wedges. A device limits the size of a binding, so there are as many buffers
//! ("windows") as needed. A draw of wedges that spans several windows becomes one draw for each.

use std::ops::Range;

use crate::render::RenderContext;
use crate::render::gpu::buffers::GrowingBuffer;
use crate::render::gpu::strided::StridedUniforms;
use crate::techniques::penumbra_wedge::geometry::records::{Wedge, WedgeLight};

/// The buffers of group 2 that all windows share.
#[derive(Clone, Copy, Debug)]
pub struct Shared<'a> {
    /// The casters of all wedges, at binding 0.
    pub casters: &'a GrowingBuffer,
    /// The records of the lights' parts, at binding 2 with a dynamic offset.
    pub lights: &'a GrowingBuffer,
    /// The coverage tables, at binding 3.
    pub tables: &'a GrowingBuffer,
}

/// The buffers of a frame's wedges. There is always at least one.
#[derive(Debug)]
pub struct WedgeWindows {
    windows: Vec<Window>,
    /// The number of wedges in a full window.
    capacity: u32,
}

#[derive(Debug)]
struct Window {
    wedges: GrowingBuffer,
    group: wgpu::BindGroup,
}

impl WedgeWindows {
    /// Makes one empty window.
    pub fn new(context: &RenderContext, layout: &wgpu::BindGroupLayout, shared: Shared) -> Self {
        let limits = context.device.limits();
        let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let mut windows = Self {
            windows: Vec::new(),
            capacity: (bytes / size_of::<Wedge>() as u64).clamp(1, u64::from(u32::MAX)) as u32,
        };
        windows.push(context, layout, shared);
        windows
    }

    fn push(&mut self, context: &RenderContext, layout: &wgpu::BindGroupLayout, shared: Shared) {
        let wedges = GrowingBuffer::new(context, "wedges", wgpu::BufferUsages::STORAGE);
        let group = bind(context, layout, &wedges, shared);
        self.windows.push(Window { wedges, group });
    }

    /// Uploads all wedges of a frame.
    pub fn write(
        &mut self,
        context: &RenderContext,
        layout: &wgpu::BindGroupLayout,
        wedges: &[Wedge],
        shared: Shared,
    ) {
        for (index, part) in wedges.chunks(self.capacity as usize).enumerate() {
            if index == self.windows.len() {
                self.push(context, layout, shared);
            }
            let window = &mut self.windows[index];
            if window.wedges.write(context, bytemuck::cast_slice(part)) {
                window.group = bind(context, layout, &window.wedges, shared);
            }
        }
    }

    /// Replaces the shared buffers.
    pub fn rebind(&mut self, context: &RenderContext, layout: &wgpu::BindGroupLayout, shared: Shared) {
        for window in &mut self.windows {
            window.group = bind(context, layout, &window.wedges, shared);
        }
    }

    /// Returns the bind group for draws that read no wedges.
    pub fn group(&self) -> &wgpu::BindGroup {
        &self.windows[0].group
    }

    /// Draws a range of the frame's wedges, one window at a time. For each window it sets group 2 with the
    /// part's record, and draws the instances.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass,
        light_offset: u32,
        indices: Range<u32>,
        wedges: Range<u32>,
    ) {
        for (window, instances) in pieces(self.capacity, wedges) {
            if let Some(window) = self.windows.get(window) {
                pass.set_bind_group(2, &window.group, &[light_offset]);
                pass.draw_indexed(indices.clone(), 0, instances);
            }
        }
    }
}

/// Returns the windows that a range spans, with the part of the range in each.
fn pieces(capacity: u32, range: Range<u32>) -> impl Iterator<Item = (usize, Range<u32>)> {
    let windows = range.start / capacity..range.end.div_ceil(capacity);
    windows.filter_map(move |window| {
        let first = window * capacity;
        let part = range.start.max(first) - first..(range.end - first).min(capacity);
        (!part.is_empty()).then_some((window as usize, part))
    })
}

fn bind(
    context: &RenderContext,
    layout: &wgpu::BindGroupLayout,
    wedges: &GrowingBuffer,
    shared: Shared,
) -> wgpu::BindGroup {
    let limit = context.device.limits().max_storage_buffer_binding_size;
    let entry =
        |binding, of: &'_ GrowingBuffer, size: u64| (binding, of.buffer.clone(), size.min(of.buffer.size()));
    let buffers = [
        entry(0, shared.casters, limit),
        entry(1, wedges, limit),
        entry(2, shared.lights, size_of::<WedgeLight>() as u64),
        entry(3, shared.tables, limit),
    ];
    let entries = buffers
        .each_ref()
        .map(|(binding, buffer, size)| wgpu::BindGroupEntry {
            binding: *binding,
            resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset: 0,
                size: std::num::NonZeroU64::new(*size),
            }),
        });
    context.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("wedges"),
        layout,
        entries: &entries,
    })
}

/// Returns the buffers that all windows of wedges share.
pub(super) fn shared<'a>(
    casters: &'a GrowingBuffer,
    lights: &'a StridedUniforms<WedgeLight>,
    tables: &'a GrowingBuffer,
) -> Shared<'a> {
    Shared {
        casters,
        lights: lights.buffer(),
        tables,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_cut_at_windows() {
        let cut = |range| pieces(10, range).collect::<Vec<_>>();
        assert_eq!(cut(3..7), [(0, 3..7)]);
        assert_eq!(cut(8..31), [(0, 8..10), (1, 0..10), (2, 0..10), (3, 0..1)]);
        assert_eq!(cut(20..30), [(2, 0..10)]);
        assert_eq!(cut(20..20), []);
    }
}
