//! Shader constants at offsets that can be bound dynamically.

use std::marker::PhantomData;

use bytemuck::Pod;

use super::buffers::GrowingBuffer;
use crate::render::RenderContext;

/// The largest alignment of dynamic offsets that WebGPU allows a device to require, bytes.
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

    /// Removes the last frame's constants, and keeps their memory.
    pub fn clear(&mut self) {
        self.bytes.clear();
    }

    /// Appends a constant, and returns its offset in bytes.
    pub fn push(&mut self, constant: &T) -> u32 {
        let at = self.bytes.len();
        self.bytes.resize(at + Self::STRIDE, 0);
        self.bytes[at..at + size_of::<T>()].copy_from_slice(bytemuck::bytes_of(constant));
        at as u32
    }

    /// Returns the offset in bytes of a constant, by its index in the order of [`Strided::push`].
    pub const fn offset(index: usize) -> u32 {
        (index * Self::STRIDE) as u32
    }

    /// The bytes of all constants, with the gaps between them. Bevy's buffers take them.
    #[cfg(any(test, feature = "bevy"))]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

/// [`Strided`] constants in a uniform buffer that grows.
#[derive(Debug)]
pub struct StridedUniforms<T> {
    /// The constants of this frame.
    pub constants: Strided<T>,
    buffer: GrowingBuffer,
}

impl<T: Pod> StridedUniforms<T> {
    /// Makes a uniform buffer without constants. It has room for one, because a buffer without room cannot be
    /// bound.
    pub fn new(context: &RenderContext, label: &'static str) -> Self {
        let mut buffer = GrowingBuffer::new(context, label, wgpu::BufferUsages::UNIFORM);
        buffer.reserve(context, Strided::<T>::STRIDE as u64, false);
        Self {
            constants: Strided::default(),
            buffer,
        }
    }

    /// Uploads the constants. Returns whether the buffer was replaced, so that it must be bound again.
    pub fn write(&mut self, context: &RenderContext) -> bool {
        self.buffer.write(context, &self.constants.bytes)
    }

    /// The buffer that holds the uploaded constants.
    pub fn buffer(&self) -> &GrowingBuffer {
        &self.buffer
    }

    /// Returns the binding of one constant, for use with a dynamic offset.
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
