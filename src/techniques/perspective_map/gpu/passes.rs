//! The passes of the blurred grounds of one light: colours of the casters, blur along two axes, lookup.
//!
//! Shaders `shaders/techniques/perspective_map/{color,blur,ground}.wgsl`

use super::pictures::Pictures;
use super::pipelines::Key;
use super::recorder::PerspectiveNode;
use crate::render::gpu::strided::Strided;
use crate::render::nodes::surfaces::{draw_batch, set_mesh};
use crate::render::recorder::{PictureInput, ResolveInput};
use crate::techniques::maps::gpu::gpu_types::MapLight;
use crate::techniques::maps::gpu::plans::LightPlan;
use crate::techniques::maps::gpu::recorded::Recorded;

impl PerspectiveNode {
    /// Records the passes that the faces of one light need: the map and, if it lights a blurred ground, the pictures of
    /// grounds.
    pub(super) fn draw_light(
        &self,
        slot: usize,
        plan: &LightPlan,
        encoder: &mut wgpu::CommandEncoder,
        input: &PictureInput,
        recorded: &mut Recorded,
    ) {
        self.maps.draw_faces(slot, plan, encoder, input, recorded);
        let Some(pictures) = self.pictures_of(slot) else {
            return;
        };
        for at in plan.faces.clone() {
            self.draw_colors(plan, at, pictures, encoder, input);
        }
        // The taps of a face may lie in others, so all faces are there before any is blurred.
        let [colors, half_blurred] = [&pictures.colors, &pictures.half_blurred];
        for (axis, source, target) in [(0, 0, half_blurred), (1, 1, colors)] {
            let Some(pipeline) = self.pipelines.get(Key::Blur { axis }) else {
                return;
            };
            for at in plan.faces.clone() {
                let face = self.maps.faces[at].face;
                let mut pass = begin(
                    encoder,
                    input,
                    plan.light,
                    "ground blur",
                    &target.layers[face],
                    None,
                );
                pass.set_pipeline(pipeline);
                pass.set_bind_group(1, &self.ground_group, &[]);
                pass.set_bind_group(2, &self.maps.map_group, &[Strided::<MapLight>::offset(slot)]);
                pass.set_bind_group(3, &pictures.groups[source], &[]);
                pass.draw(0..3, face as u32..face as u32 + 1);
            }
        }
    }

    fn draw_colors(
        &self,
        plan: &LightPlan,
        at: usize,
        pictures: &Pictures,
        encoder: &mut wgpu::CommandEncoder,
        input: &PictureInput,
    ) {
        let (Some(textures), face) = (self.maps.pool.get(&plan.key), &self.maps.faces[at]) else {
            return;
        };
        let depth = &textures.still.layers[face.face];
        let target = &pictures.colors.layers[face.face];
        let mut pass = begin(encoder, input, plan.light, "ground color", target, Some(depth));
        pass.set_bind_group(0, &self.maps.caster_group, &[]);
        pass.set_bind_group(1, &self.caster_channels.group, &[]);
        let pipeline = |casts| move |masked| self.pipelines.get(Key::Color { masked, casts });
        let (meshes, materials) = (input.meshes, input.materials);
        let casters = face.still.clone().unwrap_or(0..0);
        self.maps
            .draws
            .record(casters, &mut pass, pipeline(true), meshes, materials);
        let others = self.plans[at].clone();
        if !others.is_empty() {
            pass.set_bind_group(0, &self.other_group, &[]);
            pass.set_bind_group(1, &self.other_channels.group, &[]);
            self.others
                .record(others, &mut pass, pipeline(false), meshes, materials);
        }
    }

    /// Writes the visibility of grounds over what the lookup of the map left there.
    pub(super) fn look_up_grounds(
        &self,
        slot: usize,
        encoder: &mut wgpu::CommandEncoder,
        input: &ResolveInput,
    ) {
        let (Some(pictures), Some(pipeline)) = (self.pictures_of(slot), self.pipelines.get(Key::Ground))
        else {
            return;
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("ground lookup"),
            color_attachments: &[Some(input.masks.attachment(wgpu::LoadOp::Load))],
            depth_stencil_attachment: Some(input.targets.read_only()),
            timestamp_writes: input.timings.pass_of(input.label, "ground lookup"),
            ..Default::default()
        });
        input.record.viewport.set(&mut pass);
        let [x, y, width, height] = input.scissor;
        pass.set_scissor_rect(x, y, width, height);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, input.record.view, &[]);
        pass.set_bind_group(1, &self.object_channels.group, &[]);
        pass.set_bind_group(2, &self.maps.map_group, &[Strided::<MapLight>::offset(slot)]);
        pass.set_bind_group(3, &pictures.groups[0], &[]);
        let receivers = &input.record.receivers;
        for batch in receivers.batches.iter().filter(|batch| !batch.variant.unshadowed) {
            if let Some(mesh) = receivers.surfaces.meshes.get(batch.mesh) {
                set_mesh(&mut pass, mesh, receivers.surfaces.instances);
                draw_batch(&mut pass, mesh, batch);
            }
        }
    }
}

/// Begins a pass into one picture, which is white at first.
fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    input: &PictureInput,
    light: usize,
    label: &str,
    target: &wgpu::TextureView,
    depth: Option<&wgpu::TextureView>,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: depth.map(|view| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: None,
            stencil_ops: None,
        }),
        timestamp_writes: input.timings.pass_of(input.label(light), label),
        ..Default::default()
    })
}
