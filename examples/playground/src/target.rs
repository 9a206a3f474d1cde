//! A texture that a picture is drawn into and that the window shows.

use antumbra::prelude::*;
use glam::UVec2;

/// A picture on the GPU.
#[derive(Debug)]
pub struct Target {
    /// Size, pixels.
    pub size: UVec2,
    /// The texture.
    pub texture: wgpu::Texture,
    /// View to draw into.
    pub view: wgpu::TextureView,
    /// View for the window, whose colours are already encoded.
    pub shown: wgpu::TextureView,
}

impl Target {
    /// Format of the picture.
    pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

    /// Makes a texture of a size, which must be within the device's limits and not 0.
    pub fn new(context: &RenderContext, size: UVec2) -> Self {
        let encoded = wgpu::TextureFormat::Rgba8Unorm;
        let texture = context.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d {
                width: size.x,
                height: size.y,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: Self::FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST,
            view_formats: &[encoded],
        });
        Self {
            size,
            view: texture.create_view(&Default::default()),
            shown: texture.create_view(&wgpu::TextureViewDescriptor {
                format: Some(encoded),
                ..Default::default()
            }),
            texture,
        }
    }

    /// Writes a picture from the CPU, sRGB RGBA, rows from the top.
    pub fn write(&self, context: &RenderContext, rgba8: &[u8]) {
        if rgba8.len() as u64 != u64::from(self.size.x) * u64::from(self.size.y) * 4 {
            return;
        }
        context.queue.write_texture(
            self.texture.as_image_copy(),
            rgba8,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(self.size.x * 4),
                rows_per_image: None,
            },
            self.texture.size(),
        );
    }
}
