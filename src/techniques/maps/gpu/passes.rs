//! The passes of one light's map: casters into faces, the copy under moving casters, the conversion, and the
//! lookup.
//!
//! Shaders `shaders/techniques/maps/{caster,convert,resolve}.wgsl`

use std::ops::Range;

use super::gpu_types::MapLight;
use super::pipelines::{Key, Peel};
use super::plans::{FacePlan, LightPlan};
use super::pool::MapTextures;
use super::recorded::Recorded;
use super::recorder::MapNode;
use crate::render::RenderContext;
use crate::render::gpu::bind_groups::bind_in_order;
use crate::render::gpu::strided::Strided;
use crate::render::recorder::{PictureInput, ResolveInput};
use crate::techniques::maps::request::MapShape;
use crate::techniques::maps::settings::{MapFormat, MapSurface};

impl MapNode {
    /// Records the passes that the faces of one light need.
    pub(in crate::techniques) fn draw_faces(
        &self,
        slot: usize,
        plan: &LightPlan,
        encoder: &mut wgpu::CommandEncoder,
        input: &PictureInput,
        recorded: &mut Recorded,
    ) {
        let Some(textures) = self.pool.get(&plan.key) else {
            return;
        };
        for face in &self.faces[plan.faces.clone()] {
            self.draw_face(slot, plan, face, textures, encoder, input);
            recorded.push(&textures.records[face.face], face.still_revision, face.revision);
        }
    }

    fn draw_face(
        &self,
        slot: usize,
        plan: &LightPlan,
        face: &FacePlan,
        textures: &MapTextures,
        encoder: &mut wgpu::CommandEncoder,
        input: &PictureInput,
    ) {
        let layer = face.face;
        if let Some(range) = &face.still {
            let view = &textures.still.layers[layer];
            self.draw_casters(
                plan.light,
                encoder,
                input,
                view,
                true,
                std::slice::from_ref(range),
                None,
            );
        }
        if let (Some(range), Some(moving)) = (&face.moving, &textures.moving) {
            copy_layer(encoder, &textures.still.texture, &moving.texture, layer);
            if !range.is_empty() {
                self.draw_casters(
                    plan.light,
                    encoder,
                    input,
                    &moving.layers[layer],
                    false,
                    std::slice::from_ref(range),
                    None,
                );
            }
        }
        if let Some(shown) = &textures.shown {
            let first = &textures.all_casters().layers[layer];
            let mut second = first;
            if plan.request.surface != MapSurface::Nearest
                && let Some(scratch) = self.pool.second(plan.key.side)
            {
                let group = bind_depths(input.context, &self.long_lived.layouts.first, &[first]);
                self.draw_casters(
                    plan.light,
                    encoder,
                    input,
                    scratch,
                    true,
                    &face.peeled,
                    Some((&group, face.peel)),
                );
                second = scratch;
            }
            let group = bind_depths(input.context, &self.long_lived.layouts.surfaces, &[first, second]);
            self.convert(slot, plan, layer, &shown.layers[layer], &group, encoder, input);
        }
    }

    fn draw_casters(
        &self,
        light: usize,
        encoder: &mut wgpu::CommandEncoder,
        input: &PictureInput,
        target: &wgpu::TextureView,
        clear: bool,
        ranges: &[Range<usize>],
        peel: Option<(&wgpu::BindGroup, Peel)>,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("map"),
            color_attachments: &[],
            depth_stencil_attachment: Some(depth_attachment(target, clear)),
            timestamp_writes: input.timings.pass_of(input.label(light), "map"),
            ..Default::default()
        });
        pass.set_bind_group(0, &self.caster_group, &[]);
        if let Some((group, _)) = peel {
            pass.set_bind_group(1, group, &[]);
        }
        let peel = peel.map_or(Peel::No, |(_, peel)| peel);
        for range in ranges {
            let pipeline = |masked| self.pipelines.get(Key::Caster { masked, peel });
            self.draws
                .record(range.clone(), &mut pass, pipeline, input.meshes, input.materials);
        }
    }

    fn convert(
        &self,
        slot: usize,
        plan: &LightPlan,
        face: usize,
        target: &wgpu::TextureView,
        surfaces: &wgpu::BindGroup,
        encoder: &mut wgpu::CommandEncoder,
        input: &PictureInput,
    ) {
        let (format, surface) = (plan.request.format, plan.request.surface);
        let parallel = plan.request.shape == MapShape::Cascades;
        let key = Key::Convert {
            format,
            surface,
            parallel,
        };
        let Some(pipeline) = self.pipelines.get(key) else {
            return;
        };
        let is_depth = format == MapFormat::Depth;
        let color = [Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
                store: wgpu::StoreOp::Store,
            },
        })];
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("map conversion"),
            color_attachments: if is_depth { &[] } else { &color },
            depth_stencil_attachment: is_depth.then(|| depth_attachment(target, true)),
            timestamp_writes: input.timings.pass_of(input.label(plan.light), "map conversion"),
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(1, surfaces, &[]);
        pass.set_bind_group(2, &self.map_group, &[Strided::<MapLight>::offset(slot)]);
        pass.draw(0..3, face as u32..face as u32 + 1);
    }

    /// Records the lookup, for every pixel of the scissor. `textures` is group 3.
    pub(in crate::techniques) fn look_up(
        &self,
        slot: usize,
        textures: &wgpu::BindGroup,
        pipeline: &wgpu::RenderPipeline,
        encoder: &mut wgpu::CommandEncoder,
        input: &ResolveInput,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("map lookup"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &input.masks.mask_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Load,
                    store: wgpu::StoreOp::Store,
                },
            })],
            timestamp_writes: input.timings.pass_of(input.label, "map lookup"),
            ..Default::default()
        });
        let [x, y, width, height] = input.scissor;
        pass.set_scissor_rect(x, y, width, height);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, input.record.view, &[]);
        pass.set_bind_group(1, &input.masks.receiver_group, &[]);
        pass.set_bind_group(2, &self.map_group, &[Strided::<MapLight>::offset(slot)]);
        pass.set_bind_group(3, textures, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn depth_attachment(view: &wgpu::TextureView, clear: bool) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: if clear {
                wgpu::LoadOp::Clear(crate::conventions::DEPTH_INFINITY)
            } else {
                wgpu::LoadOp::Load
            },
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    }
}

pub(in crate::techniques) fn copy_layer(
    encoder: &mut wgpu::CommandEncoder,
    from: &wgpu::Texture,
    to: &wgpu::Texture,
    layer: usize,
) {
    let at = |texture| wgpu::TexelCopyTextureInfo {
        texture,
        mip_level: 0,
        origin: wgpu::Origin3d {
            x: 0,
            y: 0,
            z: layer as u32,
        },
        aspect: wgpu::TextureAspect::All,
    };
    let size = wgpu::Extent3d {
        depth_or_array_layers: 1,
        ..from.size()
    };
    encoder.copy_texture_to_texture(at(from), at(to), size);
}

pub(in crate::techniques) fn bind_depths(
    context: &RenderContext,
    layout: &wgpu::BindGroupLayout,
    views: &[&wgpu::TextureView],
) -> wgpu::BindGroup {
    let views = views.iter().map(|view| wgpu::BindingResource::TextureView(view));
    bind_in_order(&context.device, "map surfaces", layout, views)
}
