//! The passes of one light's pictures: casters into slices, the filter, and the lookup.
//!
//! Shaders `shaders/techniques/occlusion_texture/{caster,filter,resolve}.wgsl`

use smallvec::SmallVec;

use super::pipelines::Key;
use super::recorder::{LightPlan, SetPlan, SliceNode};
use super::textures::{PictureLayers, SliceTextures, Step};
use crate::render::gpu::strided::Strided;
use crate::render::recorder::{PictureInput, ResolveInput};
use crate::techniques::occlusion_texture::records::{OcclusionFace, OcclusionLight};

type Attachments<'a> = SmallVec<[Option<wgpu::RenderPassColorAttachment<'a>>; 4]>;

/// Clears the layers of a picture before casters are drawn.
const EMPTY: wgpu::LoadOp<wgpu::Color> = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);

/// Keeps the layers that a step of a filter overwrites, every texel of them. Software drivers would spend a quarter of the
/// filter's time on a clear.
const OVERWRITTEN: wgpu::LoadOp<wgpu::Color> = wgpu::LoadOp::Load;

/// Returns the attachments of a pass that writes the layers.
fn attachments(views: &[wgpu::TextureView], load: wgpu::LoadOp<wgpu::Color>) -> Attachments<'_> {
    let attachment = |view| {
        Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load,
                store: wgpu::StoreOp::Store,
            },
        })
    };
    views.iter().map(attachment).collect()
}

impl SliceNode {
    /// Records the passes of one light's pictures.
    pub(super) fn draw_light(
        &self,
        plan: &LightPlan,
        textures: &SliceTextures,
        encoder: &mut wgpu::CommandEncoder,
        input: &PictureInput,
    ) {
        for (slot, layers) in plan.faces.clone().zip(&textures.drawn) {
            self.draw_face(slot, plan, layers, encoder, input);
        }
        for (face, slot) in plan.faces.clone().enumerate() {
            if !self.faces[slot].filled.is_empty()
                && let Some(crossings) = textures.crossings.get(face)
            {
                self.fill_face(slot, plan, crossings, &textures.drawn[face], encoder, input);
            }
        }
        for step in textures.steps.iter().filter(|step| step.level < plan.levels) {
            if let Some(pipeline) = self.pipelines.get(step.pipeline) {
                filter_step(step, pipeline, plan.light, encoder, input);
            }
        }
    }

    /// Draws all casters into the slices of one picture.
    fn draw_face(
        &self,
        slot: usize,
        plan: &LightPlan,
        layers: &[wgpu::TextureView],
        encoder: &mut wgpu::CommandEncoder,
        input: &PictureInput,
    ) {
        let face = &self.faces[slot];
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("slices"),
            color_attachments: &attachments(layers, EMPTY),
            timestamp_writes: input.timings.pass_of(input.label(plan.light), "slices"),
            ..Default::default()
        });
        pass.set_bind_group(0, &self.caster_group, &[]);
        pass.set_bind_group(1, &self.face_group, &[Strided::<OcclusionFace>::offset(slot)]);
        let groups = plan.key.groups;
        for set in &face.draws {
            let SetPlan { closes, culled, .. } = *set;
            let pipeline = |masked| {
                self.pipelines.get(Key::Caster {
                    masked,
                    closes,
                    culled,
                    depths: plan.key.is_split,
                    format: plan.key.drawn_format(),
                    groups,
                })
            };
            self.draws.record(
                set.draws.clone(),
                &mut pass,
                pipeline,
                input.meshes,
                input.materials,
            );
        }
    }

    /// Fills the slices of one picture inside of closed casters, whose surfaces are counted first.
    fn fill_face(
        &self,
        slot: usize,
        plan: &LightPlan,
        crossings: &PictureLayers,
        layers: &[wgpu::TextureView],
        encoder: &mut wgpu::CommandEncoder,
        input: &PictureInput,
    ) {
        let groups = plan.key.groups;
        let (Some(count), Some(fill)) = (
            self.pipelines.get(Key::Crossings { groups }),
            self.pipelines.get(Key::Fill { groups }),
        ) else {
            return;
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("slice crossings"),
            color_attachments: &attachments(&crossings.written, EMPTY),
            timestamp_writes: input.timings.pass_of(input.label(plan.light), "slices"),
            ..Default::default()
        });
        pass.set_bind_group(0, &self.caster_group, &[]);
        pass.set_bind_group(1, &self.face_group, &[Strided::<OcclusionFace>::offset(slot)]);
        self.draws.record(
            self.faces[slot].filled.clone(),
            &mut pass,
            |masked| (!masked).then_some(count),
            input.meshes,
            input.materials,
        );
        drop(pass);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("slice fill"),
            color_attachments: &attachments(layers, wgpu::LoadOp::Load),
            timestamp_writes: input.timings.pass_of(input.label(plan.light), "slices"),
            ..Default::default()
        });
        pass.set_pipeline(fill);
        pass.set_bind_group(0, &crossings.read, &[]);
        pass.draw(0..3, 0..1);
    }

    /// Records the lookup, for every pixel of the scissor. `pictures` is group 3.
    pub(super) fn look_up(
        &self,
        slot: usize,
        pictures: &wgpu::BindGroup,
        pipeline: &wgpu::RenderPipeline,
        encoder: &mut wgpu::CommandEncoder,
        input: &ResolveInput,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("slice lookup"),
            color_attachments: &[Some(input.masks.attachment(wgpu::LoadOp::Load))],
            timestamp_writes: input.timings.pass_of(input.label, "slice lookup"),
            ..Default::default()
        });
        let [x, y, width, height] = input.scissor;
        pass.set_scissor_rect(x, y, width, height);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, input.record.view, &[]);
        pass.set_bind_group(1, &input.masks.receiver_group, &[]);
        pass.set_bind_group(2, &self.light_group, &[Strided::<OcclusionLight>::offset(slot)]);
        pass.set_bind_group(3, pictures, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn filter_step(
    step: &Step,
    pipeline: &wgpu::RenderPipeline,
    light: usize,
    encoder: &mut wgpu::CommandEncoder,
    input: &PictureInput,
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("slice filter"),
        color_attachments: &attachments(&step.targets, OVERWRITTEN),
        timestamp_writes: input.timings.pass_of(input.label(light), "slice filter"),
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &step.below, &[]);
    pass.draw(0..3, step.instance..step.instance + 1);
}
