//! A technique may draw the receivers of a light into its mask, by texture coordinates of their own.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::render::{
    Gpu, Leaves, MASK_FORMAT, PrepareInput, RecordInput, Recorder, RenderError, Resolve, ResolveInput,
    SURFACE_BUFFERS,
};
use antumbra::techniques::{Needs, Technique};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

const SIZE: UVec2 = UVec2::new(64, 64);

/// Dark where the first texture coordinate of a receiver is below one half.
const SHADER: &str = "
#import antumbra::surface::{VertexIn, Fragment, surface_vertex}
@vertex
fn vertex(in: VertexIn) -> Fragment { return surface_vertex(in); }
@fragment
fn fragment(in: Fragment) -> @location(0) vec4f { return vec4f(select(0.0, 1.0, in.uv.x >= 0.5)); }
";

/// A light whose visibility is painted on its receivers.
#[derive(Component, Clone, Default, PartialEq)]
struct Painted;

impl Technique for Painted {
    const NAME: &'static str = "painted";
    const NEEDS: Needs = Needs::NOTHING;

    type Recorder = Painter;

    fn recorder(gpu: &Gpu) -> Result<Painter, RenderError> {
        Painter::new(gpu)
    }
}

struct Painter {
    lights: Vec<usize>,
    pipeline: wgpu::RenderPipeline,
}

impl Painter {
    fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let device = &gpu.context.device;
        let module = gpu.shaders.compose("painter.wgsl", SHADER)?;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
        });
        let layouts = &gpu.layouts;
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&layouts.view), None, Some(&layouts.material)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("painter"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &SURFACE_BUFFERS,
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: gpu.context.depth_stencil_format(),
                depth_write_enabled: Some(false),
                depth_compare: Some(wgpu::CompareFunction::Equal),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &[Some(MASK_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let lights = Vec::new();
        Ok(Self { lights, pipeline })
    }
}

impl Resolve for Painter {
    fn resolve(&self, _: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("painter"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &input.masks.mask_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &input.targets.depth_stencil_view,
                depth_ops: None,
                stencil_ops: None,
            }),
            ..Default::default()
        });
        input.record.viewport.set(&mut pass);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, input.record.view, &[]);
        input.record.receivers.draw(&mut pass);
    }
}

impl Recorder for Painter {
    fn prepare(&mut self, world: &World, _: &PrepareInput) -> Result<(), RenderError> {
        let lights = &world.resource::<FrameLights>().lights;
        let own = |&index: &usize| lights[index].is_shadowed_by::<Painted>();
        self.lights = (0..lights.len()).filter(own).collect();
        Ok(())
    }

    fn light(&self, light: usize) -> Option<Leaves<'_>> {
        self.lights.contains(&light).then_some(Leaves::Mask(self))
    }

    fn debug(&self, _: usize, _: &mut wgpu::RenderPass, _: &RecordInput) {}

    fn batch_count(&self, _: usize) -> usize {
        1
    }
}

#[test]
fn receivers_are_drawn_into_the_mask_by_their_texture_coordinates() {
    let view = Transform::from_xyz(0.0, 4.0, 0.0).looking_at(Vec3::ZERO, Vec3::Z);
    let mut stage = Stage::empty(SIZE, Camera::default(), view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    (&mut stage.world, &mut stage.schedule).add_technique::<Painted>();
    let mut plane = |x: f32, receives: bool| {
        let mut mesh = MeshData::plane(0.5);
        mesh.uv0 = mesh
            .positions
            .iter()
            .map(|p| glam::Vec2::new(p.x + 0.5, 0.0))
            .collect();
        let material = Arc::new(Material::matte(Vec3::ONE));
        let mut plane = stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([material].into()),
            Transform::from_xyz(x, 0.0, 0.0),
        ));
        if receives {
            plane.insert(ShadowReceiver);
        }
    };
    plane(-0.8, true);
    plane(0.8, false);
    let light = Light::point(Vec3::ONE, 20.0, 20.0);
    let light = stage.spawn_light(light, Transform::from_xyz(0.0, 3.0, 1.0), None::<StencilVolume>);
    stage.world.entity_mut(light).insert(Painted);
    let rendered = stage.render().expect("the frame renders");
    let visibility = &rendered.visibility[0];
    let row = &visibility[32 * 64..33 * 64];
    // Seen from above with +Z up, +X points to the left: the receiver is in the right half of the picture.
    let dark = |half: &[f32]| half.iter().filter(|&&v| v == 0.0).count();
    let (left, right) = row.split_at(32);
    let (shown, other) = if dark(right) > 0 {
        (right, left)
    } else {
        (left, right)
    };
    assert!((4..12).contains(&dark(shown)), "half of the receiver: {row:?}");
    assert_eq!(dark(other), 0, "what is no receiver is not drawn: {row:?}");
}
