//! Rectangles and spheres shed the light that numerical integration over them gives.

use crate::harness::strict_context;
use antumbra::render::Shaders;
use antumbra::render::readback::read_buffer;
use glam::{DVec3, Vec3, Vec4};
use wgpu::util::DeviceExt;

const SHADER: &str = "
#import antumbra::area_light::{rect_irradiance, sphere_irradiance}
struct Case { to_light: vec4f, right: vec4f, up: vec4f, axis: vec4f, normal: vec4f }
@group(0) @binding(0) var<storage, read> cases: array<Case>;
@group(0) @binding(1) var<storage, read_write> results: array<vec2f>;
@compute @workgroup_size(1)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let c = cases[id.x];
    let distance = length(c.to_light.xyz);
    results[id.x] = vec2f(
        rect_irradiance(c.to_light.xyz, distance, c.right.xyz, c.up.xyz, c.axis.xyz, c.normal.xyz),
        sphere_irradiance(c.to_light.xyz / distance, distance, c.to_light.w, c.normal.xyz),
    );
}";

/// As in the shader; `radius` in `to_light.w`.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Case {
    to_light: [f32; 4],
    right: [f32; 4],
    up: [f32; 4],
    axis: [f32; 4],
    normal: [f32; 4],
}

fn cases() -> Vec<Case> {
    let mut all = Vec::new();
    let sizes: [(f32, f32); 4] = [(0.0005, 0.0005), (0.3, 0.3), (1.5, 0.2), (3.0, 3.0)];
    let normals = [
        Vec3::Y,
        Vec3::new(0.9, 0.2, 0.1),
        Vec3::new(1.0, -0.25, 0.0),
        Vec3::new(-0.4, 0.5, 0.7),
        Vec3::NEG_Y,
    ];
    for (half_width, half_height) in sizes {
        for normal in normals {
            for axis in [Vec3::NEG_Y, Vec3::new(-0.5, -0.8, 0.2), Vec3::new(0.1, 0.9, 0.2)] {
                let axis = axis.normalize();
                let right = axis.cross(Vec3::Z).normalize();
                let pad = |v: Vec3| Vec4::from((v, 0.0)).to_array();
                all.push(Case {
                    to_light: [0.4, 2.0, -0.3, half_width.min(1.9)],
                    right: pad(right * half_width),
                    up: pad(right.cross(axis) * half_height),
                    axis: pad(axis),
                    normal: pad(normal.normalize()),
                });
            }
        }
    }
    all
}

fn vec3(v: [f32; 4]) -> DVec3 {
    DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]))
}

/// Irradiance by a Lambertian rectangle and a Lambertian sphere of 1 candela, by sums.
fn integrated(case: &Case) -> [f64; 2] {
    const STEPS: usize = 400;
    let (center, right, up) = (vec3(case.to_light), vec3(case.right), vec3(case.up));
    let (axis, normal) = (vec3(case.axis), vec3(case.normal));
    let step = |i: usize| (i as f64 + 0.5) / STEPS as f64;
    let (mut rect, mut sphere) = (0.0, 0.0);
    let radius = f64::from(case.to_light[3]);
    let sin_sq = (radius / center.length()).powi(2).min(1.0);
    let towards = center.normalize();
    let (a, b) = towards.any_orthonormal_pair();
    for i in 0..STEPS {
        for j in 0..STEPS {
            let at = center + right * (2.0 * step(i) - 1.0) + up * (2.0 * step(j) - 1.0);
            let distance_sq = at.length_squared();
            let direction = at / distance_sq.sqrt();
            rect += normal.dot(direction).max(0.0) * (-axis.dot(direction)).max(0.0) / distance_sq;
            // Directions of the sphere's cone, uniform in projected solid angle about its axis.
            let sine = (step(i) * sin_sq).sqrt();
            let (s, c) = (step(j) * std::f64::consts::TAU).sin_cos();
            let cosine = (1.0 - sine * sine).sqrt();
            let direction = (a * c + b * s) * sine + towards * cosine;
            sphere += normal.dot(direction).max(0.0) / cosine;
        }
    }
    let count = (STEPS * STEPS) as f64;
    // Radiance of the sphere times projected solid angle.
    [rect / count, sphere / count * sin_sq / (radius * radius)]
}

fn on_gpu(cases: &[Case]) -> Vec<[f32; 2]> {
    let context = strict_context();
    let device = &context.device;
    let module = Shaders::new()
        .expect("the common files compose")
        .compose("area_lights test", SHADER)
        .expect("it composes");
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    let input = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(cases),
        usage: wgpu::BufferUsages::STORAGE,
    });
    let size = (cases.len() * 8) as u64;
    let output = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: input.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: output.as_entire_binding(),
            },
        ],
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(cases.len() as u32, 1, 1);
    }
    context.queue.submit([encoder.finish()]);
    let bytes = read_buffer(&context, &output, size, "results").expect("read back");
    bytemuck::pod_collect_to_vec(&bytes)
}

#[test]
fn irradiance_is_the_integral_over_the_light() {
    let cases = cases();
    let mut lit = 0;
    for (case, got) in cases.iter().zip(on_gpu(&cases)) {
        let expected = integrated(case);
        for (kind, got, expected) in [("rect", got[0], expected[0]), ("sphere", got[1], expected[1])] {
            let error = (f64::from(got) - expected).abs();
            lit += usize::from(expected > 1e-3);
            assert!(
                error <= 2e-3 * expected + 2e-4,
                "{kind}: {got}, integral {expected}, {case:?}"
            );
        }
    }
    assert!(
        lit > 40,
        "{lit}: most cases are lit, so that the comparison can fail"
    );
}
