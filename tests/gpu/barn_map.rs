//! What a light's shape costs as a formula, and as the barn map and the distance map of the paper.
//!
//! ```sh
//! cargo test --features bevy,gltf,reference,profile --test gpu barn_map -- --ignored --nocapture
//! ```
//!
//! Source: Pellacini and Vidimce 2004, "Cinematic Lighting", GPU Gems, chapter 10.4.

use std::time::Instant;

use antumbra::insides::gpu_types;
use antumbra::render::{MASK_FORMAT, MULTIPLY, RenderContext, Shaders};
use antumbra::scene::{LightDistance, LightShape};
use glam::Vec3;
use half::f16;
use wgpu::util::DeviceExt;

use crate::harness::strict_context;

/// Each form scales the mask as the pass of the light model does, at positions that vary from pixel to pixel.
const SHADER: &str = "
#import antumbra::light_shape::{LightShape, shape_factor}

@group(0) @binding(0) var<uniform> shape: LightShape;
@group(0) @binding(1) var barn_map: texture_2d<f32>;
@group(0) @binding(2) var distance_map: texture_2d<f32>;
@group(0) @binding(3) var linear: sampler;

@vertex
fn vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32((vertex & 1u) << 2u), f32((vertex & 2u) << 1u)) - 1.0, 0.0, 1.0);
}

// In light space, as far as 8 m before the light.
fn position(pixel: vec4f) -> vec3f {
    let depth = 0.3 + 7.7 * fract(dot(pixel.xy, vec2f(0.0137, 0.0071)));
    let at = vec2f(light_position(pixel.x), light_position(pixel.y));
    return vec3f(at * depth, depth);
}
fn light_position(pixel: f32) -> f32 { return pixel / 256.0 - 1.0; }

@fragment
fn nothing(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    return vec4f(position(pixel).z * 0.1);
}
@fragment
fn formula(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    return vec4f(shape_factor(position(pixel), shape));
}
@fragment
fn barn(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let at = position(pixel);
    let doors = textureSampleLevel(barn_map, linear, at.xy / at.z * 0.5 + 0.5, 0.0).r;
    let depth = smooth_edge((at.z - shape.distance.x) * shape.distance.y)
        * (1.0 - smooth_edge((at.z - shape.distance.z) * shape.distance.w));
    return vec4f(doors * depth);
}
fn smooth_edge(t: f32) -> f32 {
    let s = clamp(t, 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}
@fragment
fn maps(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let at = position(pixel);
    let doors = textureSampleLevel(barn_map, linear, at.xy / at.z * 0.5 + 0.5, 0.0).r;
    let depth = textureSampleLevel(distance_map, linear, vec2f(at.z / 8.0, 0.5), 0.0).r;
    return vec4f(doors * depth);
}
";

const SIDE: u32 = 512;
const MAP: u32 = 256;
const DRAWS: u32 = 10;
const ROUNDS: usize = 15;

fn map(
    context: &RenderContext,
    [width, height]: [u32; 2],
    value: impl Fn(f32, f32) -> f32,
) -> wgpu::TextureView {
    let center = |at: u32, count: u32| (at as f32 + 0.5) / count as f32;
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (center(x, width), center(y, height))));
    let bytes: Vec<u8> = texels
        .flat_map(|(x, y)| f16::from_f32(value(x, y)).to_le_bytes())
        .collect();
    let descriptor = wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let order = wgpu::wgt::TextureDataOrder::LayerMajor;
    context
        .device
        .create_texture_with_data(&context.queue, &descriptor, order, &bytes)
        .create_view(&Default::default())
}

/// The formula's numbers, as the shader has them.
fn constants(shape: &LightShape, distance: &LightDistance) -> gpu_types::LightShape {
    let outer = [shape.width + shape.width_edge, shape.height + shape.height_edge];
    gpu_types::LightShape {
        semi_axes: [shape.width, shape.height, outer[0], outer[1]],
        distance: [
            distance.near - distance.near_edge,
            distance.near_edge.recip(),
            distance.far,
            distance.far_edge.recip(),
        ],
        form: [2.0 / shape.round, 0.5 * shape.round, 1.0, 1.0],
        ..Default::default()
    }
}

/// The textures and numbers of the shader, in its group 0.
fn resources(context: &RenderContext) -> (wgpu::BindGroupLayout, wgpu::BindGroup) {
    let device = &context.device;
    let shape = LightShape {
        width: 0.4,
        height: 0.3,
        width_edge: 0.1,
        height_edge: 0.1,
        round: 0.5,
    };
    let distance = LightDistance {
        near: 1.0,
        far: 6.0,
        near_edge: 0.5,
        far_edge: 2.0,
    };
    let barn = map(context, [MAP, MAP], |x, y| {
        shape.factor(Vec3::new(2.0 * x - 1.0, 2.0 * y - 1.0, 1.0))
    });
    let depths = map(context, [MAP, 1], |x, _| distance.factor(8.0 * x));
    let constants = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::bytes_of(&constants(&shape, &distance)),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    });
    let texture = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let uniform = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let filtering = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    let bound = [
        (uniform, constants.as_entire_binding()),
        (texture, wgpu::BindingResource::TextureView(&barn)),
        (texture, wgpu::BindingResource::TextureView(&depths)),
        (filtering, wgpu::BindingResource::Sampler(&sampler)),
    ];
    let (mut kinds, mut entries) = (Vec::new(), Vec::new());
    for (binding, (ty, resource)) in (0..).zip(bound) {
        kinds.push(wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        });
        entries.push(wgpu::BindGroupEntry { binding, resource });
    }
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &kinds,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &entries,
    });
    (layout, group)
}

fn target(context: &RenderContext) -> wgpu::TextureView {
    let texture = context.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: SIDE,
            height: SIDE,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: MASK_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}

/// Pipelines of the fragment stages with these names.
fn pipelines<const N: usize>(
    context: &RenderContext,
    layout: &wgpu::BindGroupLayout,
    names: [&str; N],
) -> [wgpu::RenderPipeline; N] {
    let device = &context.device;
    let shaders = Shaders::new().expect("the common files compose");
    let module = shaders.compose("barn_map.wgsl", SHADER).expect("it composes");
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    names.map(|entry| {
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(entry),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: MASK_FORMAT,
                    blend: Some(MULTIPLY),
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    })
}

#[test]
#[ignore = "prints times"]
fn barn_map_and_formula_by_hand() {
    let context = strict_context();
    let (layout, group) = resources(&context);
    let names = ["nothing", "formula", "barn", "maps"];
    let pipelines = pipelines(&context, &layout, names);
    let target = target(&context);
    let draw = |pipeline: &wgpu::RenderPipeline| {
        let begin = Instant::now();
        let mut encoder = context.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: None,
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        for _ in 0..DRAWS {
            pass.draw(0..3, 0..1);
        }
        drop(pass);
        context.queue.submit([encoder.finish()]);
        let waited = context.device.poll(wgpu::PollType::wait_indefinitely());
        waited.expect("the device works");
        begin.elapsed().as_secs_f64() * 1e9 / f64::from(DRAWS * SIDE * SIDE)
    };
    // They take turns, so that drift affects all of them. The fastest round is the one that nothing disturbed.
    let mut best = [f64::INFINITY; 4];
    for _ in 0..ROUNDS {
        for (best, pipeline) in best.iter_mut().zip(&pipelines) {
            *best = best.min(draw(pipeline));
        }
    }
    println!("{}: ns a pixel, the pass included", context.adapter);
    for (name, best) in names.iter().zip(best) {
        println!("{name:8} {best:7.2}");
    }
}
