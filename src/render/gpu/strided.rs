//! Constants at a stride that a dynamic offset may have.

use std::marker::PhantomData;

use bytemuck::Pod;

use super::buffers::GrowingBuffer;
use crate::render::RenderContext;

/// The largest alignment of dynamic offsets that WebGPU allows a device to ask for, bytes.
const ALIGNMENT: usize = 256;

/// The bytes of constants of one type, each at an offset that can be bound dynamically.
#[derive(Debug)]
pub struct Strided<T> {
    bytes: Vec<u8>,
    of: PhantomData<T>,
}

impl<T> Default for Strided<T> {
    fn default() -> Self {
        Self {
            bytes: Vec::new(),
            of: PhantomData,
        }
    }
}

impl<T: Pod> Strided<T> {
    /// The number of bytes from one constant to the next.
    pub const STRIDE: usize = size_of::<T>().next_multiple_of(ALIGNMENT);

    /// Forgets the last frame's constants, and keeps their memory.
    pub fn clear(&mut self) {
        self.bytes.clear();
    }

    /// Appends a constant; its offset in bytes.
    pub fn push(&mut self, constant: &T) -> u32 {
        let at = self.bytes.len();
        self.bytes.resize(at + Self::STRIDE, 0);
        self.bytes[at..at + size_of::<T>()].copy_from_slice(bytemuck::bytes_of(constant));
        at as u32
    }

    /// The offset of a constant by its place in the order of [`Strided::push`], bytes.
    pub const fn offset(index: usize) -> u32 {
        (index * Self::STRIDE) as u32
    }

    /// All constants.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

/// [`Strided`] constants in a uniform buffer that grows.
#[derive(Debug)]
pub struct StridedUniforms<T> {
    /// This frame's constants.
    pub constants: Strided<T>,
    buffer: GrowingBuffer,
}

impl<T: Pod> StridedUniforms<T> {
    /// No constants yet.
    pub fn new(context: &RenderContext, label: &'static str) -> Self {
        Self {
            constants: Strided::default(),
            buffer: GrowingBuffer::new(context, label, wgpu::BufferUsages::UNIFORM),
        }
    }

    /// Uploads the constants; whether the buffer was exchanged, so that it must be bound anew.
    pub fn write(&mut self, context: &RenderContext) -> bool {
        self.buffer.write(context, &self.constants.bytes)
    }

    /// The buffer.
    pub fn buffer(&self) -> &GrowingBuffer {
        &self.buffer
    }

    /// The binding of one constant, for a dynamic offset.
    pub fn binding(&self) -> wgpu::BindingResource<'_> {
        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.buffer.buffer,
            offset: 0,
            size: std::num::NonZeroU64::new(size_of::<T>() as u64),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_stand_at_offsets_that_can_be_bound() {
        let mut strided = Strided::<[u32; 65]>::default();
        let offsets = [1, 2, 3].map(|value| strided.push(&[value; 65]));
        assert_eq!(offsets, [0, 512, 1024]);
        assert_eq!(Strided::<[u32; 65]>::offset(2), 1024);
        assert_eq!(strided.bytes()[1024..1028], 3u32.to_le_bytes());
        strided.clear();
        assert_eq!(strided.push(&[4; 65]), 0);
    }
}
