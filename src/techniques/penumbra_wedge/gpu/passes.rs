//! Records the passes of one light: the depth bounds, the sums group by group, and their resolve into the
//! mask.

use std::ops::Range;

use super::buffers::Sums;
use super::form::Form;
use super::pipelines::{Key, Part, ResolveKey};
use super::plans::{LightPlan, PartPlan, passes};
use super::recorder::PenumbraWedgeNode;
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::recorder::{RecordInput, ResolveInput};
use crate::techniques::penumbra_wedge::component::{CoverageMaths, Overlap, WedgeCulling};
use crate::techniques::penumbra_wedge::geometry::topology::{
    HARD_SIDE, INNER_HALF, OUTER_HALF, SEPARATORS, SHELLS,
};
use crate::techniques::penumbra_wedge::wedges::Group;

impl PenumbraWedgeNode {
    /// Records the passes that leave the mask of one light.
    pub(in crate::techniques::penumbra_wedge) fn record_mask(
        &self,
        light: usize,
        encoder: &mut wgpu::CommandEncoder,
        input: &ResolveInput,
    ) {
        let Some(plan) = self.plan_of(light) else {
            return;
        };
        let (Some(sums), Some(combined)) = (self.textures.get(plan.form), self.textures.combined()) else {
            return;
        };
        {
            let radiance = attachment(input.radiance, wgpu::LoadOp::Load);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("wedge bounds"),
                color_attachments: &[Some(radiance)],
                depth_stencil_attachment: Some(depth_stencil(input)),
                ..Default::default()
            });
            let [x, y, width, height] = input.scissor;
            pass.set_scissor_rect(x, y, width, height);
            let (near, far) = input.depth_range;
            input.light_begin.record(&mut pass, near, far);
        }
        let combines = plan.settings.overlap == Overlap::Paper;
        let mut load = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        for part in &self.parts[plan.parts.clone()] {
            let mut source = 0;
            if combines {
                let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
                encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("no coverage"),
                    color_attachments: &[Some(attachment(&combined[source], clear))],
                    ..Default::default()
                });
                for group in &self.groups[part.groups.clone()] {
                    self.record_sums(encoder, plan, part, sums, Some(group), input);
                    let key = ResolveKey {
                        form: plan.form,
                        is_sphere: part.is_sphere,
                        combines: true,
                        is_combined: false,
                    };
                    let target = attachment(&combined[1 - source], wgpu::LoadOp::Load);
                    self.record_resolve(encoder, key, target, &sums.groups[source], part, input);
                    source = 1 - source;
                }
            } else {
                let group = self.groups[part.groups.clone()].first();
                self.record_sums(encoder, plan, part, sums, group, input);
            }
            let key = ResolveKey {
                form: plan.form,
                is_sphere: part.is_sphere,
                combines: false,
                is_combined: combines,
            };
            let target = attachment(&input.masks.mask_view, load);
            self.record_resolve(encoder, key, target, &sums.groups[source], part, input);
            load = wgpu::LoadOp::Load;
        }
        if plan.form == Form::Split8 {
            self.textures.overflow().record(encoder);
        }
    }

    /// Draws one group into the sums. The scissor of the pass is already set.
    fn record_group(
        &self,
        pass: &mut wgpu::RenderPass,
        plan: &LightPlan,
        part: &PartPlan,
        group: &Group,
        input: &RecordInput,
    ) {
        let turned_pipeline = |kind, towards, turned: bool| {
            self.pipelines.get(Key {
                part: kind,
                form: plan.form,
                is_sphere: part.is_sphere,
                looks_up: plan.settings.maths == CoverageMaths::Tables,
                towards,
                mirrored: self.mirrored != turned,
            })
        };
        let pipeline = |kind, towards| turned_pipeline(kind, towards, false);
        pass.set_index_buffer(self.caps.buffer.slice(..), wgpu::IndexFormat::Uint32);
        let kinds = (1..=3).flat_map(|layers| [(layers, false), (layers, true)]);
        for (layers, is_far, turned) in kinds.flat_map(|(a, b)| [(a, b, false), (a, b, true)]) {
            let kind = if is_far {
                Part::FarCap(layers)
            } else {
                Part::NearCap(layers)
            };
            let Some(pipeline) = turned_pipeline(kind, false, turned) else {
                continue;
            };
            pass.set_pipeline(pipeline);
            for (caster, draw) in group.casters.clone().zip(&self.cap_draws[group.casters.clone()]) {
                let Some(mesh) = input.meshes.get(draw.mesh) else {
                    continue;
                };
                let caps = &draw.caps[usize::from(layers) - 1 + 3 * usize::from(turned)];
                if draw.towards || caps.is_empty() || (is_far && !draw.has_far) {
                    continue;
                }
                pass.set_vertex_buffer(0, mesh.positions.slice(..));
                pass.draw_indexed(caps.clone(), 0, caster as u32..caster as u32 + 1);
            }
        }
        pass.set_index_buffer(self.long_lived.indices.slice(..), wgpu::IndexFormat::Uint16);
        let draw = |pass: &mut wgpu::RenderPass, kind, towards, indices: Range<u32>, wedges: Range<u32>| {
            if let (Some(pipeline), false) = (pipeline(kind, towards), wedges.is_empty()) {
                pass.set_pipeline(pipeline);
                self.wedges.draw(pass, part.light_offset(), indices, wedges);
            }
        };
        for (towards, wedges) in [(true, &group.towards), (false, &group.away)] {
            for &kind in passes(plan.settings.culling, part.has_extent) {
                let indices = match kind {
                    Part::HardSide => HARD_SIDE,
                    Part::Separator => SEPARATORS,
                    Part::Shell | Part::ShellEverywhere => SHELLS,
                    _ => continue, // edge by edge, below
                };
                draw(pass, kind, towards, indices, wedges.clone());
            }
        }
        if part.has_extent && plan.settings.culling == WedgeCulling::Stencil {
            for wedge in group.wedges() {
                for (half, kind) in [(OUTER_HALF, Part::OuterHalf), (INNER_HALF, Part::InnerHalf)] {
                    draw(pass, Part::Mark, false, half.clone(), wedge..wedge + 1);
                    draw(pass, kind, false, half, wedge..wedge + 1);
                }
            }
        }
    }

    fn record_sums(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        plan: &LightPlan,
        part: &PartPlan,
        sums: &Sums,
        group: Option<&Group>,
        input: &ResolveInput,
    ) {
        let attachments: smallvec::SmallVec<[_; 4]> = sums
            .views
            .iter()
            .map(|view| Some(attachment(view, wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT))))
            .collect();
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("wedges"),
            color_attachments: &attachments,
            depth_stencil_attachment: Some(depth_stencil(input)),
            timestamp_writes: input.timings.pass_of(input.label, "wedges"),
            ..Default::default()
        });
        if let Some(group) = group {
            let [x, y, width, height] = input.scissor;
            input.record.viewport.set(&mut pass);
            pass.set_scissor_rect(x, y, width, height);
            pass.set_stencil_reference(STENCIL_IN_BOUNDS);
            pass.set_bind_group(0, input.record.view, &[]);
            pass.set_bind_group(1, &input.masks.receiver_group, &[]);
            pass.set_bind_group(2, self.wedges.group(), &[part.light_offset()]);
            self.record_group(&mut pass, plan, part, group, &input.record);
        }
    }

    fn record_resolve(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        key: ResolveKey,
        target: wgpu::RenderPassColorAttachment,
        sums: &wgpu::BindGroup,
        part: &PartPlan,
        input: &ResolveInput,
    ) {
        let Some(pipeline) = self.resolves.get(key) else {
            return;
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("wedge resolve"),
            color_attachments: &[Some(target)],
            timestamp_writes: input.timings.pass_of(input.label, "resolve"),
            ..Default::default()
        });
        let [x, y, width, height] = input.scissor;
        let [r, g, b, a] = part.share;
        pass.set_scissor_rect(x, y, width, height);
        pass.set_pipeline(pipeline);
        pass.set_blend_constant(wgpu::Color { r, g, b, a });
        pass.set_bind_group(0, input.record.view, &[]);
        pass.set_bind_group(1, &input.masks.receiver_group, &[]);
        pass.set_bind_group(2, self.wedges.group(), &[part.light_offset()]);
        pass.set_bind_group(3, sums, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn attachment(
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load,
            store: wgpu::StoreOp::Store,
        },
    }
}

fn depth_stencil<'a>(input: &ResolveInput<'a>) -> wgpu::RenderPassDepthStencilAttachment<'a> {
    wgpu::RenderPassDepthStencilAttachment {
        view: &input.targets.depth_stencil_view,
        depth_ops: None,
        stencil_ops: Some(wgpu::Operations {
            load: wgpu::LoadOp::Load,
            store: wgpu::StoreOp::Store,
        }),
    }
}
