//! A technique of somebody else, in one folder: of a light everybody sees a set share, whatever stands in between.
//!
//! It knows nothing of shot files, of Bevy, of the statistics or of the gallery, and they know nothing of it.

use antumbra::prelude::*;
use antumbra::render::{
    Gpu, Leaves, PrepareInput, RecordInput, Recorder, RenderError, Resolve, ResolveInput,
};
use antumbra::techniques::{Needs, Refusal, Statistics, Technique, erased_serde};
use bevy_ecs::prelude::*;

/// Veils a light.
#[derive(Component, Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Veil {
    /// Share of the light that is seen, 0 to 1. Default: a quarter.
    pub seen: f32,
}

impl Default for Veil {
    fn default() -> Self {
        Self { seen: 0.25 }
    }
}

impl Technique for Veil {
    const NAME: &'static str = "veil";
    const NEEDS: Needs = Needs::NOTHING;

    fn check(&self, _: &Light) -> Result<(), Refusal> {
        if (0.0..=1.0).contains(&self.seen) {
            return Ok(());
        }
        Err(Refusal::setting("seen", self.seen, "it is a share, 0 to 1"))
    }

    fn statistics(world: &World, light: usize, out: &mut Statistics) {
        let light = &world.resource::<FrameLights>().lights[light];
        let veil = world
            .get::<Veil>(light.entity)
            .filter(|_| light.is_shadowed_by::<Veil>());
        out.set("veil", veil.map(|veil| f64::from(veil.seen)));
    }

    fn parse(from: &mut dyn erased_serde::Deserializer) -> Result<Self, erased_serde::Error> {
        erased_serde::deserialize(from)
    }

    type Recorder = VeilRecorder;

    fn recorder(_: &Gpu) -> Result<VeilRecorder, RenderError> {
        Ok(VeilRecorder::default())
    }
}

/// Clears the mask.
#[derive(Default)]
pub struct VeilRecorder {
    lights: Vec<(usize, f32)>,
}

impl VeilRecorder {
    fn seen(&self, light: usize) -> Option<f32> {
        self.lights
            .iter()
            .find_map(|&(own, seen)| (own == light).then_some(seen))
    }
}

impl Recorder for VeilRecorder {
    fn prepare(&mut self, world: &World, _: &PrepareInput) -> Result<(), RenderError> {
        let lights = world.resource::<FrameLights>().lights.iter().enumerate();
        let own = lights.filter(|(_, light)| light.is_shadowed_by::<Veil>());
        self.lights.clear();
        self.lights
            .extend(own.filter_map(|(index, light)| Some((index, world.get::<Veil>(light.entity)?.seen))));
        Ok(())
    }

    fn light(&self, light: usize) -> Option<Leaves<'_>> {
        self.seen(light).map(|_| Leaves::Mask(self))
    }

    fn debug(&self, _: usize, _: &mut wgpu::RenderPass, _: &RecordInput) {}

    fn batch_count(&self, _: usize) -> usize {
        1
    }
}

impl Resolve for VeilRecorder {
    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        let seen = f64::from(self.seen(light).unwrap_or(1.0));
        let color = wgpu::Color {
            r: seen,
            g: seen,
            b: seen,
            a: seen,
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("veil"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &input.masks.mask_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(color),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
    }
}
