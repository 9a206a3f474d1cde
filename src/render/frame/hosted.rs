//! Frames of a host: another renderer draws and lights them, and takes visibility from here.
//!
//! An engine that has a picture and its depth (of a depth prepass or a G-buffer) keeps its own materials and
//! its own light shader. It says where the view is ([`Renderer::set_host`]), runs the systems, and calls
//! [`Renderer::record_hosted`] in place of [`Renderer::record`]. That call hands each light back to the
//! engine. The engine adds the light with its own shader, tested against the stencil or multiplied by the
//! mask.
//!
//! ```text
//! host's depth ─► our depth (copied, then equal to our surfaces) ─► for each light: mark or resolve ─► the host adds it
//! ```

use bevy_ecs::prelude::Entity;
use glam::{DMat4, UVec2};

use super::frame_data::ActiveLight;
use super::front_lights::LightSurfaces;
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::gpu::strided::Strided;
use crate::render::nodes::host_depth::HostDepth;
use crate::render::nodes::host_select::HostSelect;
use crate::render::nodes::keep_visibility::{KeepVisibility, Known};
use crate::render::nodes::pipelines::stencil_test;
use crate::render::pools::gpu_types;
use crate::render::renderer::Renderer;
use crate::render::{Gpu, RenderError};

/// The place and the projection of a host's view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HostView {
    /// Size of the host's radiance and depth, texels.
    pub target_size: UVec2,
    /// Upper left corner of the view in the host's targets, pixels. The size of the view is
    /// [`ViewportSize`](crate::sets::ViewportSize).
    pub viewport_origin: UVec2,
    /// The projection of the host's depth, which is 0 at the far end and greater for nearer surfaces. The
    /// projection may have a far plane or an oblique near plane. It must show the same picture as the world's
    /// [`Camera`](crate::scene::Camera).
    pub clip_from_view: DMat4,
}

/// The textures of a host's frame.
#[derive(Clone, Copy, Debug)]
pub struct HostFrame<'a> {
    /// Radiance to which the host adds lights: [`RADIANCE_FORMAT`](super::targets::RADIANCE_FORMAT), one
    /// sample.
    pub radiance: &'a wgpu::TextureView,
    /// Depth aspect of the host's frame, one sample. It must be readable as a texture.
    pub depth: &'a wgpu::TextureView,
}

/// A light that the host must add now.
#[derive(Clone, Copy, Debug)]
pub struct HostedLight<'a> {
    /// The entity of the light.
    pub entity: Entity,
    /// Index of the light in [`FrameLights`](crate::sets::FrameLights).
    pub light: usize,
    /// Rectangle of the light: x, y, width, height, in pixels of the targets. It is already set in the pass.
    /// Nothing outside of it receives the light.
    pub scissor: [u32; 4],
    /// The visible share of the light at each pixel that passes [`stencil_lit`], for soft shadows and maps.
    /// Red, green and blue hold the share by colour, and alpha holds the share of the emitter's area. Its
    /// format is [`MASK_FORMAT`](super::targets::MASK_FORMAT). Without a mask, all of the light reaches these
    /// pixels.
    pub mask: Option<&'a wgpu::TextureView>,
    /// True if the mask also holds for surfaces that show no shadows, because a
    /// [`LightFunction`](crate::render::LightFunction) scales the light. If false, the host does not apply
    /// the mask to such surfaces.
    pub is_scaled: bool,
    /// The factors of light functions, for a light whose ambient, diffuse and specular light have weights or whose
    /// shadow has a colour, if the host adds such terms ([`Renderer::set_host_terms`]). The mask then holds the
    /// visible share alone, for all surfaces, and the factors scale all terms.
    pub factors: Option<&'a wgpu::TextureView>,
    /// The weights of ambient, diffuse and specular light of the surface at each pixel, in red, green and blue, if some
    /// object that is seen has [`SurfaceWeights`](crate::scene::SurfaceWeights) and the host adds such terms. All
    /// lights of the frame then have `factors`, and the host multiplies the weights by those of the light.
    pub surface_weights: Option<&'a wgpu::TextureView>,
}

/// Returns the stencil test of the pixels that a light reaches and affects, and, if the light has no mask,
/// sees. It is the same for all techniques. The reference is already set in the pass.
pub fn stencil_lit() -> wgpu::StencilState {
    stencil_test(wgpu::CompareFunction::Equal, 0xff)
}

/// Returns the stencil test of the pixels that a light does not see, within the depths that it reaches. It
/// serves surfaces that show no shadow.
pub fn stencil_shadowed() -> wgpu::StencilState {
    stencil_test(wgpu::CompareFunction::Less, 0xff)
}

impl HostView {
    /// Checks that the view lies in the targets, and that its projection can be inverted.
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
    /// Makes the renderer draw for a host from now on. With `None` it draws without a host again. Call it
    /// before the set `PrepareGpu` of a frame.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn set_host(&mut self, host: Option<HostView>) -> Result<(), RenderError> {
        if host.is_some() && self.host_depth.is_none() {
            self.host_depth = Some(HostDepth::new(&self.gpu)?);
            self.host_select = Some(HostSelect::new(&self.gpu)?);
        }
        self.host = host;
        Ok(())
    }

    /// Tells whether the host weights ambient, diffuse and specular light, and gives shadows their colour
    /// ([`LightModel`](crate::scene::LightModel)). A host that does not gets one mask for each light, which scales
    /// all that the light gives. Default: it does not.
    pub fn set_host_terms(&mut self, adds_terms: bool) {
        self.host_terms = adds_terms;
    }

    /// Records the prepared frame over the host's picture. It calls `add` once for each light that reaches
    /// something visible, inside a pass. That pass has the host's radiance, and depth (read-only) and stencil
    /// ([`RenderContext::depth_stencil_format`](crate::render::RenderContext::depth_stencil_format)) of the
    /// same size. Viewport, scissor and stencil reference are set, and `add` sets pipeline and bind groups.
    /// Without a view, a host or a device nothing is recorded.
    pub fn record_hosted(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &HostFrame,
        add: impl FnMut(&mut wgpu::RenderPass, &HostedLight),
    ) {
        self.record_hosted_keeping(encoder, frame, None, add);
    }

    /// Gets ready for [`Renderer::record_hosted_keeping`].
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    #[cfg_attr(
        not(feature = "bevy"),
        allow(dead_code, reason = "Bevy's forward meshes alone read kept visibility")
    )]
    pub(crate) fn prepare_keeping(&mut self) -> Result<(), RenderError> {
        if self.keep_visibility.is_none() {
            self.keep_visibility = Some(KeepVisibility::new(&self.gpu)?);
        }
        Ok(())
    }

    /// Records like [`Renderer::record_hosted`], and keeps the visibility of lights in textures of
    /// [`KEPT_FORMAT`](crate::render::nodes::keep_visibility::KEPT_FORMAT). `kept` gives the texture of a light,
    /// by its index in [`FrameLights`](crate::sets::FrameLights). The texture is not written if the light reaches
    /// nothing visible.
    pub(crate) fn record_hosted_keeping<'a>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &HostFrame,
        kept: Option<&dyn Fn(usize) -> Option<&'a wgpu::TextureView>>,
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
        // Before all passes on the screen: however often a light is looked up, its pictures are drawn once.
        self.draw_pictures(recording.encoder);
        // First on the screen: every later pass tests against its depth.
        let Gpu { context, layouts, .. } = &*self.gpu;
        let depth = host_depth.bind(context, layouts, frame.depth);
        host_depth.record(&mut recording, &depth, self.batches(&self.frame.ambient));
        if let (Some(node), Some(weights)) = (&self.host_weights, self.surface_weights()) {
            node.record(&mut recording, weights, self.batches(&self.frame.weighted));
        }
        // Before the lights: techniques read depth and planes while they write the stencil.
        self.record_receivers(&mut recording, LightSurfaces::Opaque);
        // Light by light: the lights take turns with one stencil and one mask.
        for group in self.light_groups(self.timings.is_active() || kept.is_some()) {
            self.record_group(&mut recording, group, |pass, light| {
                self.begin_light(pass, light, LightSurfaces::Opaque);
                self.select_pixels(pass, light);
                pass.set_stencil_reference(STENCIL_IN_BOUNDS);
                add(pass, &self.hosted_light(light));
            });
            if let ([light], Some(kept), Some(node)) = (group, kept, &self.keep_visibility)
                && let Some(target) = kept(light.light)
            {
                node.record(
                    &mut recording,
                    target,
                    light.scissor,
                    self.known_visibility(light),
                );
            }
        }
        self.timings.end_frame(recording.encoder);
    }

    /// Clears the stencil at surfaces that the light does not affect or does not see, so that the host does not light
    /// them. No caster needs to shadow these surfaces.
    fn select_pixels(&self, pass: &mut wgpu::RenderPass, light: &ActiveLight) {
        if let Some(select) = self.host_select.as_ref().filter(|_| !light.unlit.is_empty()) {
            let batches = &self.frame.batches[light.unlit.clone()];
            select.record(pass, &self.view_group, batches, &self.surface_resources());
        }
    }

    /// The texture of the weights of surfaces, if an object of this frame has some.
    fn surface_weights(&self) -> Option<&wgpu::TextureView> {
        let masks = self.masks.as_ref().filter(|_| !self.frame.weighted.is_empty())?;
        masks.surface_weights.as_ref()
    }

    /// What there is to keep of a light's visibility.
    fn known_visibility(&self, light: &ActiveLight) -> Known<'_> {
        let has_factors = self.masks.as_ref().is_some_and(|masks| masks.factors.is_some());
        match self.mask_of(light) {
            None => Known::Stencil,
            Some(masks) if light.is_tinted && has_factors => {
                let offset = Strided::<gpu_types::Light>::offset(light.slot.0);
                Known::Tinted(masks, (&self.light_group, offset))
            }
            Some(mask) => Known::Mask(mask),
        }
    }

    fn hosted_light(&self, light: &ActiveLight) -> HostedLight<'_> {
        HostedLight {
            entity: light.entity,
            light: light.light,
            scissor: light.scissor,
            is_scaled: light.is_scaled,
            surface_weights: self.surface_weights(),
            factors: self
                .masks
                .as_ref()
                .filter(|_| light.is_tinted)
                .and_then(|masks| masks.factors.as_ref())
                .map(|factors| &factors.view),
            mask: self
                .masks
                .as_ref()
                .filter(|_| light.has_mask())
                .map(|masks| &masks.mask_view),
        }
    }
}
