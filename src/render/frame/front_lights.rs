//! Lights on the front layer: the nearest blended surfaces, after [`front_layer`](crate::render::nodes::front_layer) has found
//! their depth.

use std::ops::Range;

use super::canvas::Canvas;
use super::frame_data::ActiveLight;
use super::record::FrameOutputs;
use crate::render::nodes;
use crate::render::nodes::surface_pass::SurfacePass;
use crate::render::nodes::visibility::Shadow;
use crate::render::recorder::{RecordInput, ShadowKind};
use crate::render::renderer::Renderer;

/// Which surfaces a light is added to.
#[derive(Clone, Copy)]
pub(in crate::render) enum LightSurfaces {
    /// Those of set I that write depth.
    Opaque,
    /// The nearest blended ones.
    Front,
}

impl LightSurfaces {
    pub(in crate::render) fn pass(self, visibility: Option<ShadowKind>) -> SurfacePass {
        match (self, visibility) {
            (Self::Front, Some(visibility)) => SurfacePass::front_light(visibility),
            _ => SurfacePass::light(visibility),
        }
    }

    pub(in crate::render) fn batches(self, light: &ActiveLight) -> Range<usize> {
        match self {
            Self::Opaque => light.batches.clone(),
            Self::Front => light.front.clone(),
        }
    }

    pub(in crate::render) fn scissor(self, light: &ActiveLight) -> [u32; 4] {
        match self {
            Self::Opaque => light.scissor,
            Self::Front => light.front_scissor,
        }
    }

    pub(in crate::render) fn record_input<'a>(
        self,
        renderer: &'a Renderer,
        light: &ActiveLight,
    ) -> RecordInput<'a> {
        let casters = match self {
            Self::Opaque => None,
            Self::Front => renderer.frame.front_casters.get(light.slot),
        };
        RecordInput {
            casters,
            ..renderer.record_input()
        }
    }
}

impl Renderer {
    /// The front layer's lights, as those of opaque surfaces, with the depth of the front layer.
    pub(in crate::render) fn record_front_lights(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        canvas: &Canvas,
        outputs: &FrameOutputs,
    ) {
        let front = canvas.targets;
        let lights = || self.frame.lights.iter().filter(|light| !light.front.is_empty());
        if lights().any(ActiveLight::has_mask)
            && let Some(masks) = &self.masks
        {
            self.depth_copy.record(encoder, front, masks, &self.timings);
            if self.reads_planes() {
                nodes::receiver_plane::record(
                    encoder,
                    front,
                    masks,
                    &self.frame.viewport,
                    &self.view_group,
                    &self.frame.batches[self.frame.blended_batches.clone()],
                    &self.surface_resources(),
                    &self.timings,
                );
            }
        }
        for light in lights() {
            let label = &self.labels[light.light];
            self.resolve_mask(encoder, canvas, light, LightSurfaces::Front);
            {
                let mut pass = canvas.begin_light_pass(encoder, label, self.timings.pass(label));
                self.record_light(&mut pass, light, LightSurfaces::Front);
            }
            if let (Some(target), Some(visibility)) = (outputs.visibility.get(light.light), light.kind()) {
                nodes::visibility::record_front(
                    encoder,
                    target,
                    &front.depth_stencil_view,
                    &self.view_group,
                    Shadow {
                        kind: SurfacePass::visibility(visibility),
                        mask: self.mask_of(light),
                        scissor: light.front_scissor,
                        batches: &self.frame.batches[light.front.clone()],
                    },
                    &self.surface_resources(),
                );
            }
        }
    }
}
