//! A buffer that grows to the size of the data written into it.

use crate::render::RenderContext;

/// A GPU buffer whose capacity grows to the next power of two when needed. It never shrinks and is never
/// empty.
#[derive(Debug)]
pub struct GrowingBuffer {
    /// The buffer. Growth replaces it with another.
    pub buffer: wgpu::Buffer,
    label: &'static str,
    usage: wgpu::BufferUsages,
}

impl GrowingBuffer {
    /// Makes a small buffer of `usage` that can be written and copied.
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

    /// Makes room for `size` bytes. Returns whether the buffer was replaced. A replaced buffer has lost its
    /// content unless `keep` is true.
    pub fn reserve(&mut self, context: &RenderContext, size: u64, keep: bool) -> bool {
        if size <= self.buffer.size() {
            return false;
        }
        // The capacity exceeds the device's limits only if `size` itself does. wgpu reports that case.
        let limits = context.device.limits();
        let binding = match self.usage.contains(wgpu::BufferUsages::STORAGE) {
            true => limits.max_storage_buffer_binding_size,
            false => u64::MAX,
        };
        let limit = limits.max_buffer_size.min(binding);
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

    /// Writes `bytes` to the start of the buffer, which grows first if needed. Returns whether the buffer was
    /// replaced.
    pub fn write(&mut self, context: &RenderContext, bytes: &[u8]) -> bool {
        let regrown = self.reserve(context, bytes.len() as u64, false);
        if !bytes.is_empty() {
            context.queue.write_buffer(&self.buffer, 0, bytes);
        }
        regrown
    }
}
