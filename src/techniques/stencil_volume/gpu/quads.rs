//! Indices of side quads: two triangles that share two of four vertices.

use std::ops::Range;

use wgpu::util::DeviceExt;

use crate::render::RenderContext;

/// Number of vertices of a quad.
pub const CORNERS: u32 = 4;

/// Number of quads that indices of 16 bits can address.
const CHUNK: u32 = (1 << 16) / CORNERS;

/// One index buffer for all quads. Beyond its length, further draws use another first vertex.
#[derive(Debug)]
pub struct QuadIndices {
    buffer: wgpu::Buffer,
}

impl QuadIndices {
    /// Uploads the indices.
    pub fn new(context: &RenderContext) -> Self {
        let corners = |quad: u32| [0, 1, 2, 0, 2, 3].map(|corner| (CORNERS * quad + corner) as u16);
        let indices: Vec<u16> = (0..CHUNK).flat_map(corners).collect();
        Self {
            buffer: context
                .device
                .create_buffer_init(&wgpu::util::BufferInitDescriptor {
                    label: Some("side quads"),
                    contents: bytemuck::cast_slice(&indices),
                    usage: wgpu::BufferUsages::INDEX,
                }),
        }
    }

    /// Sets the pass's index buffer to these indices.
    pub fn set(&self, pass: &mut wgpu::RenderPass) {
        pass.set_index_buffer(self.buffer.slice(..), wgpu::IndexFormat::Uint16);
    }

    /// Draws `quads` quads.
    pub fn draw(pass: &mut wgpu::RenderPass, quads: u32, instances: Range<u32>) {
        for first in (0..quads).step_by(CHUNK as usize) {
            let count = (quads - first).min(CHUNK);
            pass.draw_indexed(0..6 * count, (CORNERS * first) as i32, instances.clone());
        }
    }
}
