//! Draws what egui leaves of a frame: into a window's surface, or into a texture.

use antumbra::prelude::*;
use egui::{ClippedPrimitive, TextureId, TexturesDelta};
use egui_wgpu::{RendererOptions, ScreenDescriptor};
use glam::UVec2;

/// egui's renderer on the device of the pictures.
pub struct Painter {
    renderer: egui_wgpu::Renderer,
    context: RenderContext,
}

impl std::fmt::Debug for Painter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Painter").finish_non_exhaustive()
    }
}

impl Painter {
    /// Makes a painter for targets of a format.
    pub fn new(context: &RenderContext, format: wgpu::TextureFormat) -> Self {
        let options = RendererOptions {
            dithering: false, // so that pictures of the same input are the same
            ..Default::default()
        };
        Self {
            renderer: egui_wgpu::Renderer::new(&context.device, format, options),
            context: context.clone(),
        }
    }

    /// Lets egui show a texture view. Its format must be `Rgba8Unorm`.
    pub fn show(&mut self, view: &wgpu::TextureView, before: Option<TextureId>) -> TextureId {
        let device = &self.context.device;
        let nearest = wgpu::FilterMode::Nearest;
        match before {
            Some(id) => {
                self.renderer
                    .update_egui_texture_from_wgpu_texture(device, view, nearest, id);
                id
            }
            None => self.renderer.register_native_texture(device, view, nearest),
        }
    }

    /// Draws a frame over what the target holds, which is cleared first.
    pub fn paint(
        &mut self,
        target: &wgpu::TextureView,
        size: UVec2,
        pixels_per_point: f32,
        primitives: &[ClippedPrimitive],
        textures: &TexturesDelta,
    ) {
        let (device, queue) = (&self.context.device, &self.context.queue);
        for (id, change) in &textures.set {
            self.renderer.update_texture(device, queue, *id, change);
        }
        let screen = ScreenDescriptor {
            size_in_pixels: size.to_array(),
            pixels_per_point,
        };
        let mut encoder = device.create_command_encoder(&Default::default());
        let before = self
            .renderer
            .update_buffers(device, queue, &mut encoder, primitives, &screen);
        {
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("window"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            self.renderer
                .render(&mut pass.forget_lifetime(), primitives, &screen);
        }
        queue.submit(before.into_iter().chain([encoder.finish()]));
        for id in &textures.free {
            self.renderer.free_texture(id);
        }
    }
}
