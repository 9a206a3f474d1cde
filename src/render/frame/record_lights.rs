//! The passes of the lights. Each light first marks or resolves the surfaces that it does not see, and is
//! then added to the surfaces that it sees.

use super::frame_data::ActiveLight;
use super::front_lights::LightSurfaces;
use super::record::FrameOutputs;
use super::recording::Recording;
use super::targets::MaskTargets;
use crate::render::nodes;
use crate::render::nodes::surface_pass::SurfacePass;
use crate::render::nodes::visibility::Shadow;
use crate::render::recorder::{Leaves, Mark, ResolveInput, ShadowKind};
use crate::render::renderer::Renderer;

impl Renderer {
    /// Records all lights of the frame on the opaque surfaces. Consecutive lights without masks share one
    /// pass. Each light has a pass of its own if passes are timed or visibility is drawn.
    pub(in crate::render) fn record_lights(&self, frame: &mut Recording, outputs: &FrameOutputs) {
        let separate = self.timings.is_active() || !outputs.visibility.is_empty();
        self.record_skipped_visibility(frame, outputs);
        for group in self.light_groups(separate) {
            self.record_group(frame, group, |pass, light| {
                self.record_light(pass, light, LightSurfaces::Opaque);
            });
            if let [light] = group {
                self.record_visibility(frame, light, outputs);
            }
        }
    }

    /// Returns the lights in their order, grouped by the pass that they share. Consecutive lights without
    /// masks share one, unless `separate` is true.
    pub(in crate::render) fn light_groups(&self, separate: bool) -> impl Iterator<Item = &[ActiveLight]> {
        self.frame
            .lights
            .chunk_by(move |a, b| !separate && !a.has_mask() && !b.has_mask())
    }

    /// The label of one light's pass.
    pub(in crate::render) fn label_of(&self, light: &ActiveLight) -> &str {
        &self.labels.all()[light.light]
    }

    /// Records one pass for the lights of a group, after the passes that leave their masks.
    pub(in crate::render) fn record_group(
        &self,
        frame: &mut Recording,
        group: &[ActiveLight],
        mut record: impl FnMut(&mut wgpu::RenderPass, &ActiveLight),
    ) {
        let label = match group {
            [light] => self.label_of(light),
            _ => "lights",
        };
        for light in group {
            self.resolve_mask(frame, light, LightSurfaces::Opaque);
        }
        let mut pass = frame.begin_light_pass(label);
        for light in group {
            pass.push_debug_group(self.label_of(light));
            record(&mut pass, light);
            pass.pop_debug_group();
        }
    }

    /// Records the depth and planes of the surfaces, which techniques that resolve masks read. It comes
    /// before the lights, because techniques read them while they write the stencil.
    pub(in crate::render) fn record_receivers(&self, frame: &mut Recording, surfaces: LightSurfaces) {
        let Some(masks) = &self.masks else { return };
        let any = |reads: fn(&ActiveLight) -> bool| {
            let mut lights = self.frame.lights.iter();
            lights.any(|light| {
                let reads = || reads(light) || self.frame.companions_of(light).any(reads);
                reads() && !surfaces.batches(light).is_empty()
            })
        };
        if any(ActiveLight::reads_depth) {
            self.depth_copy.record(frame, masks);
        }
        if any(ActiveLight::has_mask) && self.reads_planes() {
            let drawn = match surfaces {
                LightSurfaces::Opaque => &self.frame.ambient,
                LightSurfaces::Front => &self.frame.blended_batches,
            };
            nodes::receiver_plane::record(frame, &masks.receiver_plane_view, self.batches(drawn));
        }
    }

    /// Returns whether the technique of any light with a mask reads the receivers' planes.
    pub(in crate::render) fn reads_planes(&self) -> bool {
        let companions = self.frame.companions.iter().map(|companion| &companion.shadow);
        let mut lights = self.frame.lights.iter().chain(companions);
        lights.any(ActiveLight::reads_planes)
    }

    /// Leaves the mask of a light that has one: the visibility that its technique resolves, times the
    /// functions that scale the light.
    pub(in crate::render) fn resolve_mask(
        &self,
        frame: &mut Recording,
        light: &ActiveLight,
        surfaces: LightSurfaces,
    ) {
        let Some(masks) = self.masks.as_ref().filter(|_| light.has_mask()) else {
            return;
        };
        let input = self.resolve_input(frame, light, surfaces, masks);
        let scissor = input.scissor;
        match self.leaves(light) {
            Some(Leaves::Mask(resolve)) => resolve.resolve(light.light, frame.encoder, &input),
            Some(Leaves::Stencil(mark)) => self.mask_of_stencil(frame, light, mark, &input),
            None => nodes::light_function::clear(frame, masks, scissor),
        }
        self.darken_by_companions(frame, light, surfaces);
        // In our own frames, surfaces that show no shadow of a tinted light have a shader of their own.
        let own_shader = light.is_tinted && self.host.is_none();
        if (light.is_scaled || light.is_tinted) && !own_shader {
            let batches = self.batches(&surfaces.batches(light));
            nodes::light_function::record_unshadowed(frame, masks, scissor, batches);
        }
        self.scale_mask(frame, light, &input);
    }

    /// Everything that a technique may use to leave the mask of a light or companion in `masks`.
    pub(in crate::render) fn resolve_input<'a>(
        &'a self,
        frame: &Recording<'a>,
        light: &ActiveLight,
        surfaces: LightSurfaces,
        masks: &'a MaskTargets,
    ) -> ResolveInput<'a> {
        ResolveInput {
            context: &self.gpu.context,
            record: surfaces.record_input(self, light),
            radiance: frame.canvas.radiance,
            targets: frame.canvas.targets,
            masks,
            scissor: surfaces.scissor(light),
            depth_range: light.depth_range,
            light_begin: &self.light_begin,
            timings: &self.timings,
            label: self.label_of(light),
            labels: self.labels.all(),
        }
    }

    /// Marks the stencil of a light or companion, and makes its mask of it.
    pub(in crate::render) fn mask_of_stencil(
        &self,
        frame: &mut Recording,
        light: &ActiveLight,
        mark: &dyn Mark,
        input: &ResolveInput,
    ) {
        self.mark_apart(frame, light, mark, input);
        if let Some(stencil_to_mask) = &self.stencil_to_mask {
            stencil_to_mask.record(frame, input.masks, input.scissor);
        }
    }

    /// Marks the stencil of a light in a pass of its own, before a mask is made of it.
    fn mark_apart(&self, frame: &mut Recording, light: &ActiveLight, mark: &dyn Mark, input: &ResolveInput) {
        let mut pass = frame.begin_light_pass(input.label);
        let [x, y, width, height] = input.scissor;
        pass.set_scissor_rect(x, y, width, height);
        let (near, far) = light.depth_range;
        self.light_begin.record(&mut pass, near, far);
        mark.mark(light.light, &mut pass, &input.record);
    }

    /// Multiplies the mask of a light by the functions that scale it. If the light's shadow has a colour, the
    /// functions have a mask of their own, because they scale what is shadowed as well.
    fn scale_mask(&self, frame: &mut Recording, light: &ActiveLight, input: &ResolveInput) {
        let mut attachment = input.masks.attachment(wgpu::LoadOp::Load);
        match &input.masks.factors {
            Some(factors) if light.is_tinted => {
                attachment = input.masks.attachment(wgpu::LoadOp::Clear(wgpu::Color::WHITE));
                attachment.view = &factors.view;
            }
            _ if !light.is_scaled => return,
            _ => {}
        }
        let mut pass = frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("light function"),
            color_attachments: &[Some(attachment)],
            timestamp_writes: frame.timings.pass_of(input.label, "light function"),
            ..Default::default()
        });
        let [x, y, width, height] = input.scissor;
        pass.set_scissor_rect(x, y, width, height);
        for function in self
            .functions
            .iter()
            .filter(|function| function.scales(light.light))
        {
            function.draw(light.light, &mut pass, input);
        }
    }

    /// Begins the stencil of a light. If the light's technique counts there, it marks the surfaces that the light does not
    /// see. Whatever the technique, surfaces in one place are lit once by the stencil.
    pub(in crate::render) fn begin_light(
        &self,
        pass: &mut wgpu::RenderPass,
        light: &ActiveLight,
        surfaces: LightSurfaces,
    ) {
        let [x, y, width, height] = surfaces.scissor(light);
        pass.set_scissor_rect(x, y, width, height);
        let (near, far) = light.depth_range;
        self.light_begin.record(pass, near, far);
        if let (Some(Leaves::Stencil(mark)), Some(ShadowKind::Stencil)) = (self.leaves(light), light.kind()) {
            mark.mark(light.light, pass, &surfaces.record_input(self, light));
        }
    }

    /// Records one light: marks the surfaces that it does not see, and adds it to the surfaces that it sees.
    pub(in crate::render) fn record_light(
        &self,
        pass: &mut wgpu::RenderPass,
        light: &ActiveLight,
        surfaces: LightSurfaces,
    ) {
        self.begin_light(pass, light, surfaces);
        nodes::light_accumulate::record(
            pass,
            &self.view_group,
            (&self.light_group, light.slot),
            surfaces.pass(light),
            self.mask_of(light),
            self.batches(&surfaces.batches(light)),
            &self.surface_resources(),
        );
    }

    /// The bind group 3 of passes that read the mask of a light.
    pub(in crate::render) fn mask_of(&self, light: &ActiveLight) -> Option<&wgpu::BindGroup> {
        let masks = self.masks.as_ref().filter(|_| light.has_mask())?;
        match &masks.factors {
            Some(factors) if light.is_tinted => Some(&factors.group),
            _ => Some(&masks.mask_group),
        }
    }

    /// The shadow that the picture of a light's visibility shows. It is `None` for a light without a
    /// technique and without a light function.
    pub(in crate::render) fn shadow_of(
        &self,
        light: &ActiveLight,
        surfaces: LightSurfaces,
    ) -> Option<Shadow<'_>> {
        Some(Shadow {
            kind: SurfacePass::visibility(light.kind()?),
            mask: self
                .masks
                .as_ref()
                .filter(|_| light.has_mask())
                .map(|masks| &masks.mask_group),
            scissor: surfaces.scissor(light),
            batches: self.batches(&surfaces.batches(light)),
        })
    }

    fn record_visibility(&self, frame: &mut Recording, light: &ActiveLight, outputs: &FrameOutputs) {
        if let Some(target) = outputs.visibility.get(light.light) {
            let shadow = self.shadow_of(light, LightSurfaces::Opaque);
            nodes::visibility::record(frame, target, shadow);
        }
    }

    /// Records, into the pictures of visibility, the surfaces that were not drawn for a light because the
    /// light does not see them.
    pub(in crate::render) fn record_dark(&self, frame: &mut Recording, outputs: &FrameOutputs) {
        for (light, batches) in &self.frame.dark {
            if let Some(target) = outputs.visibility.get(*light) {
                nodes::visibility::record_dark(frame, target, self.batches(batches));
            }
        }
    }

    /// Clears the visibility of skipped lights to 1. The surfaces that such a light does not see are added
    /// later.
    fn record_skipped_visibility(&self, frame: &mut Recording, outputs: &FrameOutputs) {
        let skipped = |&(index, _): &(usize, _)| self.frame.lights.iter().all(|light| light.light != index);
        for (_, target) in outputs.visibility.iter().enumerate().filter(skipped) {
            nodes::visibility::record(frame, target, None);
        }
    }
}
