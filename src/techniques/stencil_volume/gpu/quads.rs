//! Indices of side quads. A quad is two triangles that share two of its four vertices.

use std::ops::Range;

use wgpu::util::DeviceExt;

use crate::render::RenderContext;

/// The number of vertices of a quad.
pub const CORNERS: u32 = 4;

/// The number of quads that 16-bit indices can address.
const CHUNK: u32 = (1 << 16) / CORNERS;

/// One index buffer for all quads. More quads than it holds take further draws with another first vertex.
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
