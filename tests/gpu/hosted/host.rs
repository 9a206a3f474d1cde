//! An engine with a depth prepass of its own: f32 matrices through world space, another rasterized position than ours.

use antumbra::prelude::*;
use antumbra::render::readback::read_texture;
use antumbra::render::{HostFrame, HostView, stencil_lit};
use antumbra::render::{RADIANCE_FORMAT, create_target};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::{DMat4, Mat4, UVec2, Vec3};
use wgpu::util::DeviceExt;

const WGSL: &str = "
struct Draw { clip_from_world: mat4x4f, world_from_local: mat4x4f }
@group(0) @binding(0) var<uniform> draw: Draw;
@vertex fn surface(@location(0) position: vec3f) -> @builtin(position) @invariant vec4f {
    let world = draw.world_from_local * vec4f(position, 1.0);
    return draw.clip_from_world * world;
}
@vertex fn everywhere(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32((vertex & 1u) << 2u), f32((vertex & 2u) << 1u)) - 1.0, 0.0, 1.0);
}
@fragment fn lit() -> @location(0) vec4f { return vec4f(1.0); }
@group(0) @binding(0) var mask: texture_2d<f32>;
@fragment fn masked(@builtin(position) at: vec4f) -> @location(0) vec4f {
    return vec4f(textureLoad(mask, vec2u(at.xy), 0).r);
}
";

/// The host's textures and pipelines.
pub struct Host {
    context: RenderContext,
    module: wgpu::ShaderModule,
    pub view: HostView,
    pub depth: wgpu::Texture,
    pub radiance: wgpu::Texture,
    /// Left out of the host's picture, though the world has it.
    pub hidden: Option<Entity>,
}

impl Host {
    pub fn new(context: &RenderContext, view: HostView) -> Self {
        let size = view.target_size;
        let module = context.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("host"),
            source: wgpu::ShaderSource::Wgsl(WGSL.into()),
        });
        Self {
            context: context.clone(),
            module,
            view,
            depth: create_target(context, "host depth", size, wgpu::TextureFormat::Depth32Float).unwrap(),
            radiance: create_target(context, "host radiance", size, RADIANCE_FORMAT).unwrap(),
            hidden: None,
        }
    }

    fn pipeline(
        &self,
        fragment: Option<&str>,
        depth_stencil: wgpu::DepthStencilState,
    ) -> wgpu::RenderPipeline {
        let targets = [Some(wgpu::ColorTargetState {
            format: RADIANCE_FORMAT,
            blend: Some(wgpu::BlendState {
                color: wgpu::BlendComponent {
                    src_factor: wgpu::BlendFactor::One,
                    dst_factor: wgpu::BlendFactor::One,
                    operation: wgpu::BlendOperation::Add,
                },
                alpha: wgpu::BlendComponent::REPLACE,
            }),
            write_mask: wgpu::ColorWrites::ALL,
        })];
        let positions = [wgpu::VertexBufferLayout {
            array_stride: 12,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3],
        }];
        let entry_point = Some(if fragment.is_some() {
            "everywhere"
        } else {
            "surface"
        });
        self.context
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("host"),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &self.module,
                    entry_point,
                    compilation_options: Default::default(),
                    buffers: if fragment.is_some() { &[] } else { &positions },
                },
                primitive: Default::default(),
                depth_stencil: Some(depth_stencil),
                multisample: Default::default(),
                fragment: fragment.map(|entry_point| wgpu::FragmentState {
                    module: &self.module,
                    entry_point: Some(entry_point),
                    compilation_options: Default::default(),
                    targets: &targets,
                }),
                multiview_mask: None,
                cache: None,
            })
    }

    /// The host's depth prepass.
    pub fn draw_depth(&self, world: &mut World, viewport: UVec2) {
        let device = &self.context.device;
        let pipeline = self.pipeline(
            None,
            wgpu::DepthStencilState {
                format: wgpu::TextureFormat::Depth32Float,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            },
        );
        let camera = world
            .query_filtered::<&GlobalTransform, With<Camera>>()
            .single(world);
        let world_from_view = Mat4::from(camera.expect("one camera").affine());
        let clip_from_world = self.view.clip_from_view.as_mat4() * world_from_view.inverse();
        let mut encoder = device.create_command_encoder(&Default::default());
        let target = self.depth.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("host depth"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &target,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        let [x, y] = self.view.viewport_origin.as_vec2().to_array();
        pass.set_viewport(x, y, viewport.x as f32, viewport.y as f32, 0.0, 1.0);
        pass.set_pipeline(&pipeline);
        let mut objects = world.query::<(Entity, &SceneMesh, &GlobalTransform)>();
        for (_, mesh, transform) in objects
            .iter(world)
            .filter(|(entity, ..)| Some(*entity) != self.hidden)
        {
            let matrices = [clip_from_world, Mat4::from(transform.affine())].map(|m| m.to_cols_array());
            let buffer = |label, contents: &[u8], usage| {
                device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                    label: Some(label),
                    contents,
                    usage,
                })
            };
            let constants = buffer(
                "host draw",
                bytemuck::cast_slice(&matrices),
                wgpu::BufferUsages::UNIFORM,
            );
            let positions: &[Vec3] = &mesh.0.positions;
            let vertices = buffer(
                "host positions",
                bytemuck::cast_slice(positions),
                wgpu::BufferUsages::VERTEX,
            );
            let indices = buffer(
                "host indices",
                bytemuck::cast_slice(&mesh.0.indices),
                wgpu::BufferUsages::INDEX,
            );
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("host draw"),
                layout: &pipeline.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: constants.as_entire_binding(),
                }],
            });
            pass.set_bind_group(0, &group, &[]);
            pass.set_vertex_buffer(0, vertices.slice(..));
            pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..mesh.0.indices.len() as u32, 0, 0..1);
        }
        drop(pass);
        self.context.queue.submit([encoder.finish()]);
    }

    /// Lets the renderer mark, and adds 1 to what each light sees: the lights in their order, and the sum in the targets.
    pub fn add_lights(&self, renderer: &Renderer) -> (Vec<Entity>, Vec<f32>) {
        let device = &self.context.device;
        let depth_stencil = |stencil| wgpu::DepthStencilState {
            format: self.context.depth_stencil_format(),
            depth_write_enabled: Some(false),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil,
            bias: Default::default(),
        };
        let lit = self.pipeline(Some("lit"), depth_stencil(stencil_lit()));
        let masked = self.pipeline(Some("masked"), depth_stencil(stencil_lit()));
        let mut encoder = device.create_command_encoder(&Default::default());
        let radiance = self.radiance.create_view(&Default::default());
        let depth = self.depth.create_view(&Default::default());
        let frame = HostFrame {
            radiance: &radiance,
            depth: &depth,
        };
        let mut added = Vec::new();
        renderer.record_hosted(&mut encoder, &frame, |pass, light| {
            added.push(light.entity);
            match light.mask {
                None => pass.set_pipeline(&lit),
                Some(mask) => {
                    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                        label: Some("mask"),
                        layout: &masked.get_bind_group_layout(0),
                        entries: &[wgpu::BindGroupEntry {
                            binding: 0,
                            resource: wgpu::BindingResource::TextureView(mask),
                        }],
                    });
                    pass.set_pipeline(&masked);
                    pass.set_bind_group(0, &group, &[]);
                }
            }
            pass.draw(0..3, 0..1);
        });
        self.context.queue.submit([encoder.finish()]);
        let rows = read_texture(
            &self.context,
            &self.radiance,
            wgpu::TextureAspect::All,
            "host radiance",
        );
        let values = rows
            .unwrap()
            .bytes
            .chunks_exact(8)
            .map(|texel| half::f16::from_le_bytes([texel[0], texel[1]]).to_f32())
            .collect();
        (added, values)
    }

    /// Texels of the view, by row, of a picture of the targets.
    pub fn crop(&self, values: &[f32], viewport: UVec2) -> Vec<f32> {
        let [x, y] = self.view.viewport_origin.to_array();
        let row = |line: u32| {
            let at = ((y + line) * self.view.target_size.x + x) as usize;
            &values[at..at + viewport.x as usize]
        };
        (0..viewport.y).flat_map(row).copied().collect()
    }
}

/// Reversed depth with a far plane, as some engines have it; shows the picture of `camera`.
pub fn finite_projection(camera: &Camera, far: f64) -> DMat4 {
    let mut m = camera.clip_from_view();
    let near = f64::from(camera.near);
    // z_clip = a z_view + b: 1 · near at the near plane, 0 at the far one.
    m.z_axis.z = near / (far - near);
    m.w_axis.z = near * far / (far - near);
    m
}

/// A near plane that cuts askew, as for a portal: depth is 1 on it, less beyond.
pub fn oblique_projection(camera: &Camera) -> DMat4 {
    let mut m = camera.clip_from_view();
    // Beyond the plane −0.3 x − z = 0.4 of view space. Depth is 1 − k (−0.3 x − z − 0.4) / w, and k the greatest that keeps
    // it above 0 in all of the picture.
    let (right, _) = camera.half_extent_at_unit_distance();
    let k = 1.0 / (1.0 + 0.3 * right);
    m.x_axis.z = 0.3 * k;
    m.z_axis.z = k - 1.0;
    m.w_axis.z = 0.4 * k;
    m
}

/// The picture of an orthographic camera in the depth of one that sees farther.
pub fn far_parallel_projection(camera: &Camera, _: f64) -> DMat4 {
    let mut farther = *camera;
    farther.orthographic.as_mut().expect("an orthographic camera").far = 1000.0;
    farther.clip_from_view()
}
