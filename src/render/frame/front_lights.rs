//! Lights on the front layer, which is the nearest blended surfaces. They come after
//! [`front_layer`](crate::render::nodes::front_layer) has drawn the depth of those surfaces.

use std::ops::Range;

use super::frame_data::ActiveLight;
use super::record::FrameOutputs;
use super::recording::Recording;
use super::targets::FrameTargets;
use crate::render::nodes;
use crate::render::nodes::surface_pass::SurfacePass;
use crate::render::recorder::{Receivers, RecordInput};
use crate::render::renderer::Renderer;

/// The surfaces that a light is added to.
#[derive(Clone, Copy)]
pub(in crate::render) enum LightSurfaces {
    /// The surfaces of the light's set I that write depth.
    Opaque,
    /// The nearest blended surfaces.
    Front,
}

impl LightSurfaces {
    pub(in crate::render) fn pass(self, light: &ActiveLight) -> SurfacePass {
        match (self, light.kind()) {
            (Self::Opaque, _) if light.is_tinted => SurfacePass::LightTinted,
            (Self::Front, _) if light.is_tinted => SurfacePass::FrontLightTinted,
            (Self::Opaque, _) if light.is_scaled => SurfacePass::LightScaled,
            (Self::Front, _) if light.is_scaled => SurfacePass::FrontLightScaled,
            (Self::Front, Some(visibility)) => SurfacePass::front_light(visibility),
            (_, visibility) => SurfacePass::light(visibility),
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
            Self::Front => renderer.frame.front_casters.get(light.slot.0),
        };
        RecordInput {
            view: &renderer.view_group,
            meshes: &renderer.meshes,
            materials: &renderer.materials,
            table: &renderer.table,
            viewport: renderer.frame.viewport,
            casters,
            receivers: Receivers {
                batches: renderer.batches(&self.batches(light)),
                surfaces: renderer.surface_resources(),
            },
        }
    }
}

impl Renderer {
    /// Records the lights of the front layer. It works as for opaque surfaces, but with the depth of the
    /// front layer.
    pub(in crate::render) fn record_front_lights(
        &self,
        frame: &mut Recording,
        front: Option<&FrameTargets>,
        outputs: &FrameOutputs,
    ) {
        let Some(front) = front else {
            return;
        };
        let mut frame = frame.on(front);
        self.record_receivers(&mut frame, LightSurfaces::Front);
        for light in self.frame.lights.iter().filter(|light| !light.front.is_empty()) {
            self.resolve_mask(&mut frame, light, LightSurfaces::Front);
            let mut pass = frame.begin_light_pass(self.label_of(light));
            self.record_light(&mut pass, light, LightSurfaces::Front);
            drop(pass);
            let shadow = self.shadow_of(light, LightSurfaces::Front);
            if let (Some(target), Some(shadow)) = (outputs.visibility.get(light.light), shadow) {
                nodes::visibility::record_front(&mut frame, target, shadow);
            }
        }
    }
}
