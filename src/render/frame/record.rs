//! The frame: its passes in order.

use super::canvas::Canvas;
use super::frame_data::{ActiveLight, LightShadow};
use super::front_lights::LightSurfaces;
use super::targets::FrameTargets;
use crate::render::nodes;
use crate::render::nodes::surface_pass::SurfacePass;
use crate::render::nodes::visibility::Shadow;
use crate::render::recorder::{Leaves, PictureInput, ResolveInput};
use crate::render::renderer::Renderer;

/// Where a frame's results go beside the radiance in the renderer's targets.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameOutputs<'a> {
    /// The tonemapped picture; its format must have been prepared ([`Renderer::prepare_output`]).
    pub picture: Option<&'a wgpu::TextureView>,
    /// One view of [`VISIBILITY_FORMAT`](crate::render::nodes::pipelines::VISIBILITY_FORMAT) for each light of
    /// [`FrameLights`](crate::sets::FrameLights), or none.
    pub visibility: &'a [wgpu::TextureView],
}

impl Renderer {
    /// Makes what is needed to write pictures of this format. Once, and after [`RenderSettings::exposure`]
    /// changed.
    ///
    /// [`RenderSettings::exposure`]: crate::render::RenderSettings::exposure
    pub fn prepare_output(&mut self, format: wgpu::TextureFormat) {
        self.tonemap
            .prepare(&self.context, format, self.settings.sanitized().exposure);
    }

    /// Records the prepared frame. Without a view, a size or a device it records nothing.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, outputs: &FrameOutputs) {
        let (Some(targets), Some((radiance, tonemap_group))) = (&self.targets, &self.radiance) else {
            return;
        };
        if self.context.is_lost() {
            return;
        }
        self.timings.begin_frame();
        let resources = self.surface_resources();
        let canvas = Canvas {
            radiance: &radiance.view,
            targets,
            viewport: self.frame.viewport,
        };

        // Before anything of the screen: however many times a light is looked up, its pictures are drawn once.
        self.draw_pictures(encoder);

        // First of the screen, for every later pass tests against its depth.
        let background = self.settings.sanitized().background.as_dvec3();
        nodes::ambient::record(
            encoder,
            &canvas,
            wgpu::Color {
                r: background.x,
                g: background.y,
                b: background.z,
                a: 1.0,
            },
            &self.view_group,
            &self.frame.batches[self.frame.ambient.clone()],
            &resources,
            &self.timings,
        );

        self.record_receivers(encoder, targets);

        // Light by light, so that one stencil and one mask serve all of them. Lights with stencils that follow one
        // another share a pass, unless somebody looks at each.
        let separate = self.timings.is_active() || !outputs.visibility.is_empty();
        self.record_skipped_visibility(encoder, targets, outputs);
        for group in self.light_groups(separate) {
            self.record_group(encoder, &canvas, group, |pass, light| {
                self.record_light(pass, light, LightSurfaces::Opaque);
            });
            if let [light] = group {
                self.record_visibility(encoder, targets, light, outputs);
            }
        }
        self.record_dark(encoder, targets, outputs);

        // Last of the radiance: blended surfaces stand before all that was lit.
        let front = self.front.as_ref().filter(|_| self.frame.has_front_layer());
        if let Some(front) = front {
            nodes::front_layer::record(
                encoder,
                targets,
                front,
                &self.view_group,
                &self.frame.batches[self.frame.blended_batches.clone()],
                &resources,
                &self.timings,
            );
        }
        if !self.frame.blended.is_empty() {
            let writes = self.timings.pass("blended");
            let mut pass = canvas.begin_light_pass(encoder, "blended", writes);
            nodes::blended::record(
                &mut pass,
                &self.view_group,
                &self.light_group,
                &self.frame.blended,
                &self.frame.batches,
                &self.frame.blended_lights,
                front.map(|front| &front.depth_group),
                &resources,
            );
        }
        if let Some(front) = front {
            let canvas = Canvas {
                targets: front,
                ..canvas
            };
            self.record_front_lights(encoder, &canvas, outputs);
        }
        if self.settings.debug_volumes {
            let mut pass = canvas.begin_light_pass(encoder, "debug", None);
            self.record_debug(&mut pass);
        }

        if let Some(picture) = outputs.picture {
            self.tonemap
                .record(encoder, picture, tonemap_group, self.timings.pass("tonemap"));
        }
        self.timings.end_frame(encoder);
    }

    /// Lets the techniques draw their light-space pictures.
    pub(in crate::render) fn draw_pictures(&self, encoder: &mut wgpu::CommandEncoder) {
        let input = PictureInput {
            context: &self.context,
            meshes: &self.meshes,
            materials: &self.materials,
            timings: &self.timings,
            labels: &self.labels,
        };
        for technique in self.techniques.iter() {
            technique.draw_pictures(encoder, &input);
        }
    }

    /// The lights in their order, those together that share a pass: with stencils alone, one after the other, unless each is
    /// to be separate.
    pub(in crate::render) fn light_groups(&self, separate: bool) -> impl Iterator<Item = &[ActiveLight]> {
        self.frame
            .lights
            .chunk_by(move |a, b| !separate && !a.has_mask() && !b.has_mask())
    }

    /// One pass for the lights of a group, after what leaves their masks.
    pub(in crate::render) fn record_group(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        canvas: &Canvas,
        group: &[ActiveLight],
        mut record: impl FnMut(&mut wgpu::RenderPass, &ActiveLight),
    ) {
        let label = match group {
            [light] => self.labels[light.light].as_str(),
            _ => "lights",
        };
        for light in group {
            self.resolve_mask(encoder, canvas, light, LightSurfaces::Opaque);
        }
        let mut pass = canvas.begin_light_pass(encoder, label, self.timings.pass(label));
        for light in group {
            pass.push_debug_group(&self.labels[light.light]);
            record(&mut pass, light);
            pass.pop_debug_group();
        }
    }

    /// What techniques that resolve masks read of the opaque surfaces. Before the lights, for they read it while they
    /// write the stencil.
    pub(in crate::render) fn record_receivers(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &FrameTargets,
    ) {
        let Some(masks) = &self.masks else {
            return;
        };
        if !self.frame.lights.iter().any(ActiveLight::has_mask) {
            return;
        }
        self.depth_copy.record(encoder, targets, masks, &self.timings);
        if self.reads_planes() {
            nodes::receiver_plane::record(
                encoder,
                targets,
                masks,
                &self.frame.viewport,
                &self.view_group,
                &self.frame.batches[self.frame.ambient.clone()],
                &self.surface_resources(),
                &self.timings,
            );
        }
    }

    /// Whether a technique of the frame's lights with masks reads the receivers' planes.
    pub(in crate::render) fn reads_planes(&self) -> bool {
        self.frame.lights.iter().any(ActiveLight::reads_planes)
    }

    /// Lets the technique of a light leave its mask, if it does.
    pub(in crate::render) fn resolve_mask(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        canvas: &Canvas,
        light: &ActiveLight,
        surfaces: LightSurfaces,
    ) {
        if let (Some(Leaves::Mask(resolve)), Some(masks)) = (self.leaves(light), &self.masks) {
            let input = ResolveInput {
                context: &self.context,
                record: surfaces.record_input(self, light),
                device: &self.context.device,
                radiance: canvas.radiance,
                targets: canvas.targets,
                masks,
                scissor: surfaces.scissor(light),
                depth_range: light.depth_range,
                light_begin: &self.light_begin,
                timings: &self.timings,
                label: &self.labels[light.light],
                labels: &self.labels,
            };
            resolve.resolve(light.light, encoder, &input);
        }
    }

    /// Begins the stencil of a light, and lets its technique mark what it does not see if it does so there.
    pub(in crate::render) fn mark_light(
        &self,
        pass: &mut wgpu::RenderPass,
        light: &ActiveLight,
        surfaces: LightSurfaces,
    ) {
        let [x, y, width, height] = surfaces.scissor(light);
        pass.set_scissor_rect(x, y, width, height);
        if let Some(Leaves::Stencil(mark)) = self.leaves(light) {
            let (near, far) = light.depth_range;
            self.light_begin.record(pass, near, far);
            mark.mark(light.light, pass, &surfaces.record_input(self, light));
        }
    }

    /// One light: mark what it does not see, add it where it does.
    pub(in crate::render) fn record_light(
        &self,
        pass: &mut wgpu::RenderPass,
        light: &ActiveLight,
        surfaces: LightSurfaces,
    ) {
        self.mark_light(pass, light, surfaces);
        nodes::light_accumulate::record(
            pass,
            &self.view_group,
            &self.light_group,
            light.slot,
            surfaces.pass(light.kind()),
            self.mask_of(light),
            &self.frame.batches[surfaces.batches(light)],
            &self.surface_resources(),
        );
    }

    /// Group 3 of passes that read the mask of a light.
    pub(in crate::render) fn mask_of(&self, light: &ActiveLight) -> Option<&wgpu::BindGroup> {
        let masks = self.masks.as_ref().filter(|_| light.has_mask())?;
        Some(&masks.mask_group)
    }

    fn record_visibility(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &FrameTargets,
        light: &ActiveLight,
        outputs: &FrameOutputs,
    ) {
        let Some(target) = outputs.visibility.get(light.light) else {
            return;
        };
        nodes::visibility::record(
            encoder,
            target,
            &targets.depth_stencil_view,
            &self.view_group,
            light.kind().map(|visibility| Shadow {
                kind: SurfacePass::visibility(visibility),
                mask: self.mask_of(light),
                scissor: light.scissor,
                batches: &self.frame.batches[light.batches.clone()],
            }),
            &self.surface_resources(),
        );
    }

    /// Surfaces that were not drawn for a light because it does not see them.
    fn record_dark(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &FrameTargets,
        outputs: &FrameOutputs,
    ) {
        for (light, batches) in &self.frame.dark {
            if let Some(target) = outputs.visibility.get(*light) {
                nodes::visibility::record_dark(
                    encoder,
                    target,
                    &targets.depth_stencil_view,
                    &self.view_group,
                    &self.frame.batches[batches.clone()],
                    &self.surface_resources(),
                );
            }
        }
    }

    /// Lights that are skipped have visibility 1 but where they do not see a surface.
    fn record_skipped_visibility(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &FrameTargets,
        outputs: &FrameOutputs,
    ) {
        let skipped = |&(index, _): &(usize, _)| self.frame.lights.iter().all(|light| light.light != index);
        for (_, target) in outputs.visibility.iter().enumerate().filter(skipped) {
            nodes::visibility::record(
                encoder,
                target,
                &targets.depth_stencil_view,
                &self.view_group,
                None,
                &self.surface_resources(),
            );
        }
    }

    fn record_debug(&self, pass: &mut wgpu::RenderPass) {
        for light in &self.frame.lights {
            let [x, y, width, height] = light.scissor;
            pass.set_scissor_rect(x, y, width, height);
            if let Some(LightShadow { technique, .. }) = light.shadow {
                self.techniques[technique.0].debug(light.light, pass, &self.record_input());
            }
        }
    }

    /// Surface passes whose pipelines a frame needs, by batch.
    pub(in crate::render) fn require_pipelines(&mut self) {
        let reads_planes = self.reads_planes();
        let Self {
            frame,
            pipelines,
            context,
            host,
            ..
        } = self;
        let mut require = |pass, batches: std::ops::Range<usize>| {
            for batch in &frame.batches[batches] {
                pipelines.require(context, pass, batch.variant);
            }
        };
        let drawn = match host {
            Some(_) => SurfacePass::HostSurface,
            None => SurfacePass::Ambient,
        };
        require(drawn, frame.ambient.clone());
        if reads_planes {
            require(SurfacePass::ReceiverPlane, frame.ambient.clone());
            require(SurfacePass::ReceiverPlane, frame.blended_batches.clone());
        }
        for light in &frame.lights {
            let visibility = light.kind();
            require(SurfacePass::light(visibility), light.batches.clone());
            if let Some(visibility) = visibility {
                require(SurfacePass::visibility(visibility), light.batches.clone());
            }
        }
        for (_, batches) in &frame.dark {
            require(SurfacePass::Dark, batches.clone());
        }
        for light in &frame.lights {
            if let Some(visibility) = light.kind() {
                require(SurfacePass::front_light(visibility), light.front.clone());
                require(SurfacePass::visibility(visibility), light.front.clone());
                require(SurfacePass::VisibilityFront, light.front.clone());
            }
        }
        let blended = [SurfacePass::AmbientBlended, SurfacePass::LightBlended];
        let front = [SurfacePass::LightBehindFront, SurfacePass::FrontDepth];
        for pass in blended
            .into_iter()
            .chain(front.into_iter().filter(|_| frame.has_front_layer()))
        {
            require(pass, frame.blended_batches.clone());
        }
    }
}
