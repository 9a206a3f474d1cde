//! A buffer that grows to what is written into it.

use crate::render::RenderContext;

/// A GPU buffer whose capacity doubles when it must; never shrinks, never empty.
#[derive(Debug)]
pub struct GrowingBuffer {
    /// The buffer; exchanged when it grows.
    pub buffer: wgpu::Buffer,
    label: &'static str,
    usage: wgpu::BufferUsages,
}

impl GrowingBuffer {
    /// A small buffer of `usage` that can be written and copied.
    pub fn new(context: &RenderContext, label: &'static str, usage: wgpu::BufferUsages) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        Self {
            buffer: Self::create(context, label, usage, 1024),
            label,
            usage,
        }
    }

    fn create(context: &RenderContext, label: &str, usage: wgpu::BufferUsages, size: u64) -> wgpu::Buffer {
        context.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// Makes room for `size` bytes; whether the buffer was exchanged. Its content is lost then unless `keep`.
    pub fn reserve(&mut self, context: &RenderContext, size: u64, keep: bool) -> bool {
        if size <= self.buffer.size() {
            return false;
        }
        // Never past the device's limit unless what is asked for is: then wgpu reports it.
        let limit = context.device.limits().max_buffer_size;
        let capacity = size.next_power_of_two().min(limit).max(size).next_multiple_of(4);
        let grown = Self::create(context, self.label, self.usage, capacity);
        if keep {
            let mut encoder = context.device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(&self.buffer, 0, &grown, 0, self.buffer.size());
            context.queue.submit([encoder.finish()]);
        }
        self.buffer = grown;
        true
    }

    /// Writes `bytes` to the start, growing first; whether the buffer was exchanged.
    pub fn write(&mut self, context: &RenderContext, bytes: &[u8]) -> bool {
        let regrown = self.reserve(context, bytes.len() as u64, false);
        if !bytes.is_empty() {
            context.queue.write_buffer(&self.buffer, 0, bytes);
        }
        regrown
    }
}
