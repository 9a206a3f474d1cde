//! The passes of one light's smoothies.
//!
//! Shader `shaders/techniques/smoothie/edge.wgsl`

use std::ops::Range;

use super::pipelines::Key;
use super::recorder::SmoothieNode;
use crate::render::gpu::strided::Strided;
use crate::render::recorder::PictureInput;
use crate::techniques::maps::gpu::passes::{bind_depths, copy_layer};
use crate::techniques::maps::gpu::plans::LightPlan;
use crate::techniques::maps::gpu::recorded::Recorded;
use crate::techniques::smoothie::expand::VERTICES;
use crate::techniques::smoothie::records::SmoothieFace;
use crate::techniques::smoothie::shade::CLEAR;

/// One pass of smoothies into one layer.
struct Layer<'a> {
    light: usize,
    /// Index of the face among those that are drawn in this frame.
    slot: usize,
    target: &'a wgpu::TextureView,
    clear: bool,
    /// Depth of all casters and of the still ones.
    depths: [&'a wgpu::TextureView; 2],
    draws: Range<usize>,
}

impl SmoothieNode {
    /// Records the passes that the faces of one light need: casters first, then their smoothies.
    pub(super) fn draw_light(
        &self,
        slot: usize,
        plan: &LightPlan,
        encoder: &mut wgpu::CommandEncoder,
        input: &PictureInput,
        recorded: &mut Recorded,
    ) {
        self.maps.draw_faces(slot, plan, encoder, input, recorded);
        let Some(textures) = self.maps.pool.get(&plan.key) else {
            return;
        };
        let Some(beside) = &textures.beside else {
            return;
        };
        for slot in plan.faces.clone() {
            let (face_plan, smoothies) = (&self.maps.faces[slot], &self.plans[slot]);
            let face = face_plan.face;
            let still = &textures.still.layers[face];
            let layer = |target, clear, all, draws: &Range<usize>| Layer {
                light: plan.light,
                slot,
                target,
                clear,
                depths: [all, still],
                draws: draws.clone(),
            };
            if face_plan.still.is_some() {
                let layer = layer(&beside.still.layers[face], true, still, &smoothies.still);
                self.draw_layer(&layer, encoder, input);
            }
            if let (Some(_), Some(moving), Some(depth)) =
                (&face_plan.moving, &beside.moving, &textures.moving)
            {
                copy_layer(encoder, &beside.still.texture, &moving.texture, face);
                if !smoothies.moving.is_empty() {
                    let (target, all) = (&moving.layers[face], &depth.layers[face]);
                    self.draw_layer(&layer(target, false, all, &smoothies.moving), encoder, input);
                }
            }
        }
    }

    fn draw_layer(&self, layer: &Layer, encoder: &mut wgpu::CommandEncoder, input: &PictureInput) {
        let clear = wgpu::Color {
            r: f64::from(CLEAR.x),
            g: f64::from(CLEAR.y),
            b: 0.0,
            a: 1.0,
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("smoothies"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: layer.target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: if layer.clear {
                        wgpu::LoadOp::Clear(clear)
                    } else {
                        wgpu::LoadOp::Load
                    },
                    store: wgpu::StoreOp::Store,
                },
            })],
            timestamp_writes: input.timings.pass_of(input.label(layer.light), "smoothies"),
            ..Default::default()
        });
        let Some(pipeline) = self.pipelines.get(Key::Edges).filter(|_| !layer.draws.is_empty()) else {
            return;
        };
        let depths = bind_depths(
            input.context,
            &self.maps.long_lived.layouts.surfaces,
            &layer.depths,
        );
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.edge_group, &[]);
        pass.set_bind_group(
            1,
            &self.face_group,
            &[Strided::<SmoothieFace>::offset(layer.slot)],
        );
        pass.set_bind_group(2, &depths, &[]);
        for edges in &self.smoothies.draws[layer.draws.clone()] {
            pass.draw(0..VERTICES, edges.clone());
        }
    }
}
