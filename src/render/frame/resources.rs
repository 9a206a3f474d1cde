//! Targets and buffers that a frame needs.

use glam::UVec2;

use super::frame_data::{ActiveCompanion, ActiveLight};
use super::targets::{FrameTargets, MaskTargets, RadianceTarget};
use crate::render::gpu::runs::joined;
use crate::render::nodes::darker_mask::DarkerMask;
use crate::render::nodes::host_weights::HostWeights;
use crate::render::nodes::light_function::StencilToMask;
use crate::render::pools::gpu_types;
use crate::render::recorder::ShadowKind;
use crate::render::renderer::{Renderer, bind_lights, bind_view};
use crate::render::{Gpu, RenderError};

/// Objects whose constants did not change are uploaded with their neighbours if there are at most this many in a row, which
/// makes 8 kilobytes.
const SMALL_GAP: usize = 64;

impl Renderer {
    /// Makes the targets of a size, unless they are there.
    pub(super) fn resize(&mut self, size: UVec2) -> Result<(), RenderError> {
        let is_there = self.targets.as_ref().is_some_and(|targets| targets.size == size);
        if is_there && self.radiance.is_none() == self.host.is_some() {
            return Ok(());
        }
        self.targets = None;
        self.radiance = None;
        self.front = None;
        self.masks = None;
        if size.min_element() == 0 {
            return Ok(()); // there is nothing to draw
        }
        let gpu = &self.gpu;
        let targets = FrameTargets::new(&gpu.context, &gpu.layouts, "depth and stencil", size)?;
        if self.host.is_none() {
            let radiance = RadianceTarget::new(&gpu.context, size)?;
            let tonemap_group = self.tonemap.bind(gpu, &radiance.view);
            self.radiance = Some((radiance, tonemap_group));
        }
        self.targets = Some(targets);
        Ok(())
    }

    /// Makes the targets of masks and of the front layer if a light of the frame needs them.
    pub(super) fn require_targets(&mut self) -> Result<(), RenderError> {
        let Some(targets) = &self.targets else {
            return Ok(());
        };
        let Gpu { context, layouts, .. } = &*self.gpu;
        if self.masks.is_none() && self.frame.lights.iter().any(ActiveLight::has_mask) {
            self.masks = Some(MaskTargets::new(context, layouts, targets)?);
        }
        let companions = &self.frame.companions;
        let mut companions = companions.iter().filter(|companion| companion.casts);
        let is_marked = |companion: &ActiveCompanion| companion.shadow.kind() == Some(ShadowKind::Stencil);
        let is_companion_marked = companions.clone().any(is_marked);
        if let (Some(masks), true) = (&mut self.masks, companions.next().is_some()) {
            masks.require_second(context, layouts)?;
            if self.darker_mask.is_none() {
                self.darker_mask = Some(DarkerMask::new(&self.gpu)?);
            }
        }
        let mut lights = self.frame.lights.iter();
        if let (Some(masks), true) = (&mut self.masks, lights.any(|light| light.is_tinted)) {
            masks.require_factors(context, layouts)?;
        }
        if let (Some(masks), false) = (&mut self.masks, self.frame.weighted.is_empty()) {
            masks.require_surface_weights(context)?;
            if self.host_weights.is_none() {
                self.host_weights = Some(HostWeights::new(&self.gpu)?);
            }
        }
        let is_marked =
            is_companion_marked || self.frame.lights.iter().any(ActiveLight::makes_mask_of_stencil);
        if self.stencil_to_mask.is_none() && is_marked {
            self.stencil_to_mask = Some(StencilToMask::new(&self.gpu)?);
        }
        if self.front.is_none() && self.frame.has_front_layer() {
            let label = "front depth and stencil";
            self.front = Some(FrameTargets::new(context, layouts, label, targets.size)?);
        }
        Ok(())
    }

    /// Uploads the constants of all objects, or of those that changed and a few between them.
    ///
    /// # Errors
    /// [`RenderError::Limit`] if the device cannot bind so many.
    pub(super) fn write_objects(&mut self, all: bool) -> Result<(), RenderError> {
        let rows = self.table.constants();
        let work = &mut self.frame.matrices;
        work.computed = self.table.changed.count_ones(..);
        let context = &self.gpu.context;
        if !all {
            let changed = self.table.changed.ones().map(|object| object..object + 1);
            for run in joined(changed, SMALL_GAP) {
                work.uploaded += run.len();
                work.uploads += 1;
                let offset = (run.start * size_of::<gpu_types::Object>()) as u64;
                let bytes = bytemuck::cast_slice(&rows[run]);
                context.queue.write_buffer(&self.objects.buffer, offset, bytes);
            }
            return Ok(());
        }
        let bytes: &[u8] = bytemuck::cast_slice(rows);
        let limits = context.device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        if bytes.len() as u64 > limit {
            return Err(RenderError::Limit {
                what: "the list of all objects",
                needed: bytes.len() as u64,
                limit,
            });
        }
        (work.uploaded, work.uploads) = (rows.len(), 1);
        if self.objects.write(context, bytes) {
            self.view_group = bind_view(&self.gpu, &self.view_buffer, &self.objects.buffer);
        }
        Ok(())
    }

    /// Uploads the constants of all lights.
    pub(super) fn write_lights(&mut self) {
        if self.lights.write(&self.gpu.context) {
            self.light_group = bind_lights(&self.gpu, &self.lights);
        }
    }
}
