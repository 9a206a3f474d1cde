//! Frames within a host's.

use bevy_ecs::prelude::Entity;
use glam::UVec2;

use super::{RenderContext, Renderer};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct HostTarget {
    pub size: UVec2,
    pub origin: UVec2,
}
#[allow(missing_docs)]
pub struct HostFrame<'a> {
    pub radiance: &'a wgpu::TextureView,
    pub depth: &'a wgpu::TextureView,
}
#[allow(missing_docs)]
pub struct HostedLight<'a> {
    pub entity: Entity,
    pub light: usize,
    pub scissor: [u32; 4],
    pub visibility: HostedVisibility<'a>,
}
#[allow(missing_docs)]
pub enum HostedVisibility<'a> {
    Lit,
    Stencil,
    Mask(&'a wgpu::TextureView),
}
#[allow(missing_docs)]
pub fn stencil_lit() -> wgpu::StencilState {
    wgpu::StencilState::default()
}
#[allow(missing_docs)]
pub fn stencil_shadowed() -> wgpu::StencilState {
    wgpu::StencilState::default()
}
impl RenderContext {
    #[allow(missing_docs)]
    pub fn hosted(device: wgpu::Device, queue: wgpu::Queue, adapter: String) -> Self {
        Self::from_device(device, queue, adapter)
    }
}
impl Renderer {
    #[allow(missing_docs)]
    pub fn set_host(&mut self, host: Option<HostTarget>) {
        self.host = host;
    }
    #[allow(missing_docs)]
    pub fn record_hosted(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &HostFrame,
        shade: &mut dyn FnMut(&mut wgpu::RenderPass<'_>, &HostedLight),
    ) {
        let Some(host) = self.host else { return };
        let depth = self.context.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: host.size.x,
                height: host.size.y,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.context.depth_stencil_format(),
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let view = depth.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: frame.radiance,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Load,
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0),
                    store: wgpu::StoreOp::Store,
                }),
            }),
            ..Default::default()
        });
        for active in &self.frame.lights {
            let [x, y, w, h] = active.scissor;
            let scissor = [x + host.origin.x, y + host.origin.y, w, h];
            pass.set_scissor_rect(scissor[0], scissor[1], w, h);
            shade(
                &mut pass,
                &HostedLight {
                    entity: Entity::PLACEHOLDER,
                    light: active.light,
                    scissor,
                    visibility: HostedVisibility::Lit,
                },
            );
        }
    }
}
