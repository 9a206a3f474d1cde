//! Frames that another renderer draws and lights, with visibility from here.
//!
//! An engine that has a picture and its depth (of a depth prepass or a G-buffer) keeps its own materials and its own
//! light shader. It tells where the view is ([`Renderer::set_host`]), runs the systems, and in place of
//! [`Renderer::record`] calls [`Renderer::record_hosted`], which comes back for each light: the engine then adds the
//! light as it likes, tested against the stencil or multiplied by the mask.
//!
//! ```text
//! host's depth ─► our depth (copied, then equal to our surfaces) ─► for each light: mark or resolve ─► the host adds it
//! ```

use bevy_ecs::prelude::Entity;
use glam::{DMat4, UVec2};

use super::frame_data::ActiveLight;
use super::front_lights::LightSurfaces;
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::nodes::host_depth::HostDepth;
use crate::render::nodes::host_select::HostSelect;
use crate::render::nodes::pipelines::stencil_test;
use crate::render::recorder::ShadowKind;
use crate::render::renderer::Renderer;
use crate::render::{Gpu, RenderError};

/// Where and how a host shows the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HostView {
    /// Texels of the host's radiance and depth.
    pub target_size: UVec2,
    /// Upper left corner of the view in them, pixels; its size is [`ViewportSize`](crate::sets::ViewportSize).
    pub viewport_origin: UVec2,
    /// The projection that the host's depth is of: 0 at the far end, greater for what is nearer. It may have a far plane
    /// or an oblique near plane, and must show the same picture as the world's [`Camera`](crate::scene::Camera).
    pub clip_from_view: DMat4,
}

/// What a host has of the frame.
#[derive(Clone, Copy, Debug)]
pub struct HostFrame<'a> {
    /// Radiance to add to, [`RADIANCE_FORMAT`](super::targets::RADIANCE_FORMAT), one sample.
    pub radiance: &'a wgpu::TextureView,
    /// Depth aspect of what it shows, one sample; it can be read as a texture.
    pub depth: &'a wgpu::TextureView,
}

/// A light that the host is to add now.
#[derive(Clone, Copy, Debug)]
pub struct HostedLight<'a> {
    /// Its entity.
    pub entity: Entity,
    /// Index into [`FrameLights`](crate::sets::FrameLights).
    pub light: usize,
    /// x, y, width, height, pixels of the targets; set in the pass. Nothing outside receives the light.
    pub scissor: [u32; 4],
    /// For soft shadows and maps: how much of the light reaches each pixel that passes [`stencil_lit`], by colour in rgb, of
    /// the emitter's area in a; [`MASK_FORMAT`](super::targets::MASK_FORMAT). Without it, all of the light does.
    pub mask: Option<&'a wgpu::TextureView>,
    /// The mask holds for surfaces that show no shadows too, as a [`LightFunction`](crate::render::LightFunction) scales the
    /// light. Else the host leaves the mask out for such surfaces.
    pub is_scaled: bool,
}

/// The stencil test of pixels that a light reaches, affects and, if it has no mask, sees; whatever its technique. The
/// reference is set in the pass.
pub fn stencil_lit() -> wgpu::StencilState {
    stencil_test(wgpu::CompareFunction::Equal, 0xff)
}

/// The stencil test of pixels that it does not see, within the depths that it reaches: for surfaces that are to show no
/// shadow.
pub fn stencil_shadowed() -> wgpu::StencilState {
    stencil_test(wgpu::CompareFunction::Less, 0xff)
}

impl HostView {
    /// Whether the view lies in the targets.
    pub(in crate::render) fn check(&self, viewport: UVec2) -> Result<(), RenderError> {
        let end = self.viewport_origin.saturating_add(viewport);
        if end.cmple(self.target_size).all() && self.clip_from_view.inverse().is_finite() {
            return Ok(());
        }
        Err(RenderError::HostView {
            viewport,
            origin: self.viewport_origin,
            target_size: self.target_size,
        })
    }
}

impl Renderer {
    /// Draws from now on for a host, or with `None` alone again. Before the set `PrepareGpu` of a frame.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn set_host(&mut self, host: Option<HostView>) -> Result<(), RenderError> {
        if host.is_some() && self.host_depth.is_none() {
            self.host_depth = Some(HostDepth::new(&self.gpu)?);
            self.host_select = Some(HostSelect::new(&self.gpu)?);
        }
        self.host = host;
        Ok(())
    }

    /// Records the prepared frame over what the host has drawn, and calls `add` once for each light that reaches something
    /// visible, inside a pass with the host's radiance, and with depth (read-only) and stencil
    /// ([`RenderContext::depth_stencil_format`](crate::render::RenderContext::depth_stencil_format)) of the same size. Viewport, scissor and stencil reference are set;
    /// pipeline and bind groups are what `add` sets. Without a view, a host or a device it records nothing.
    pub fn record_hosted(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &HostFrame,
        mut add: impl FnMut(&mut wgpu::RenderPass, &HostedLight),
    ) {
        let (Some(targets), Some(host_depth)) = (&self.targets, &self.host_depth) else {
            return;
        };
        if self.host.is_none() || !self.frame.has_view {
            return;
        }
        let Some(mut recording) = self.begin_recording(encoder, frame.radiance, targets) else {
            return;
        };
        // Before anything of the screen: however often a light is looked up, its pictures are drawn once.
        self.draw_pictures(recording.encoder);
        // First of the screen: every later pass tests against its depth.
        let Gpu { context, layouts, .. } = &*self.gpu;
        let depth = host_depth.bind(context, layouts, frame.depth);
        host_depth.record(&mut recording, &depth, self.batches(&self.frame.ambient));
        // Before the lights: techniques read depth and planes while they write the stencil.
        self.record_receivers(&mut recording, LightSurfaces::Opaque);
        // Light by light: one stencil and one mask serve them in turn.
        for group in self.light_groups(self.timings.is_active()) {
            self.record_group(&mut recording, group, |pass, light| {
                self.mark_light(pass, light, LightSurfaces::Opaque);
                self.select_pixels(pass, light);
                pass.set_stencil_reference(STENCIL_IN_BOUNDS);
                add(pass, &self.hosted_light(light));
            });
        }
        self.timings.end_frame(recording.encoder);
    }

    /// Begins the stencil of a light whose technique has not, and leaves nothing lit in it of surfaces that the light does not
    /// affect, or does not see: no caster need shadow these.
    fn select_pixels(&self, pass: &mut wgpu::RenderPass, light: &ActiveLight) {
        if light.kind() != Some(ShadowKind::Stencil) {
            let (near, far) = light.depth_range;
            self.light_begin.record(pass, near, far);
        }
        if let Some(select) = self.host_select.as_ref().filter(|_| !light.unlit.is_empty()) {
            let batches = &self.frame.batches[light.unlit.clone()];
            select.record(pass, &self.view_group, batches, &self.surface_resources());
        }
    }

    fn hosted_light(&self, light: &ActiveLight) -> HostedLight<'_> {
        HostedLight {
            entity: light.entity,
            light: light.light,
            scissor: light.scissor,
            is_scaled: light.is_scaled,
            mask: self
                .masks
                .as_ref()
                .filter(|_| light.has_mask())
                .map(|masks| &masks.mask_view),
        }
    }
}
