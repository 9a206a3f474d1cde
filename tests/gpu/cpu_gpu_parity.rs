//! GPU stages compute what their CPU twins compute.

use crate::harness::strict_context;
use antumbra::insides::gpu_types;
use antumbra::insides::{TO_INFINITY, far_position};
use antumbra::prelude::*;
use antumbra::render::Shaders;
use antumbra::render::readback::read_buffer;
use glam::{Mat4, Quat, Vec3, Vec4};
use wgpu::util::DeviceExt;

const FILE: &str = "shaders/techniques/stencil_volume/volume.wgsl";

/// Calls the shader's own function; bound beside what the file declares.
const WRAPPER: &str = "
struct ParityCase { position_local: vec3f, caster: u32 }
@group(1) @binding(0) var<storage, read> parity_cases: array<ParityCase>;
@group(1) @binding(1) var<storage, read_write> parity_results: array<vec4f>;
@compute @workgroup_size(64)
fn parity(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&parity_cases) {
        let one = parity_cases[id.x];
        parity_results[id.x] = far_position(casters[one.caster], one.position_local);
    }
}
";

/// One vertex, pushed away from one light, of an object with one matrix.
#[derive(Clone, Copy, Debug)]
struct Case {
    light_local: Vec4,
    extrusion: f32,
    position_local: Vec3,
    clip_from_local: Mat4,
}

impl Case {
    /// What the twin says, in clip space.
    fn expected(&self) -> Vec4 {
        let far = far_position(self.light_local, self.extrusion, self.position_local);
        (self.clip_from_local.as_dmat4() * far.as_dvec4()).as_vec4()
    }

    /// How far the GPU may be off, each component: WGSL lets it fuse or round between operations, and the sum of a
    /// row has four products. With the identity and a volume to infinity nothing rounds but one subtraction.
    fn tolerance(&self) -> Vec4 {
        if self.extrusion == TO_INFINITY && self.clip_from_local == Mat4::IDENTITY {
            return Vec4::ZERO;
        }
        let light = self.light_local.truncate().abs();
        let from_light = self.position_local.abs() * self.light_local.w + light;
        let base = light + self.position_local.abs() * (1.0 - self.light_local.w);
        let local = (base + from_light * self.extrusion.max(1.0)).extend(1.0);
        let columns = self
            .clip_from_local
            .to_cols_array_2d()
            .map(|column| Vec4::from(column).abs());
        let sum = Mat4::from_cols(columns[0], columns[1], columns[2], columns[3]) * local;
        sum * (8.0 * f32::EPSILON)
    }
}

/// Random numbers from a seed.
struct Random(fastrand::Rng);

impl Random {
    fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    fn unit(&mut self) -> f32 {
        self.0.f32()
    }

    fn vec(&mut self, half: f32) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| (2.0 * self.unit() - 1.0) * half))
    }
}

fn cases() -> Vec<Case> {
    let mut random = Random::new(7);
    let projection = Camera::default().clip_from_view().as_mat4();
    let mut cases: Vec<Case> = (0..40_000)
        .map(|index| {
            let size = 10f32.powi(index % 7 - 3);
            let light = random.vec(size);
            Case {
                light_local: if index % 3 == 0 {
                    light.normalize_or(Vec3::Y).extend(0.0)
                } else {
                    light.extend(1.0)
                },
                extrusion: if index % 2 == 0 {
                    1.0 + 999.0 * random.unit()
                } else {
                    TO_INFINITY
                },
                position_local: random.vec(size),
                clip_from_local: if index % 5 < 2 {
                    Mat4::IDENTITY
                } else {
                    let turn =
                        Quat::from_euler(glam::EulerRot::XYZ, random.unit() * 6.0, random.unit() * 6.0, 0.3);
                    projection * Mat4::from_rotation_translation(turn, random.vec(size))
                },
            }
        })
        .collect();
    // A vertex exactly at the light, at the origin, and the light at the origin.
    for (light, position) in [
        (Vec3::ONE, Vec3::ONE),
        (Vec3::ONE, Vec3::ZERO),
        (Vec3::ZERO, Vec3::X),
    ] {
        for extrusion in [TO_INFINITY, 1.0, 1000.0] {
            cases.push(Case {
                light_local: light.extend(1.0),
                extrusion,
                position_local: position,
                clip_from_local: Mat4::IDENTITY,
            });
        }
    }
    cases
}

/// Runs the shader's function on the GPU, its source changed by `spoil`.
fn on_gpu(context: &RenderContext, cases: &[Case], spoil: impl Fn(&str) -> String) -> Vec<Vec4> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(FILE);
    let source = spoil(&std::fs::read_to_string(path).expect("the shader is there")) + WRAPPER;
    let module = Shaders::new()
        .and_then(|shaders| shaders.compose(FILE, &source))
        .expect("the wrapped file composes");
    let device = &context.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("parity"),
        source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
    });
    let storage = |contents: &[u8]| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("parity"),
            contents,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        })
    };
    let objects: Vec<gpu_types::Object> = cases
        .iter()
        .map(|case| gpu_types::Object {
            clip_from_local: case.clip_from_local.to_cols_array_2d(),
            ..Default::default()
        })
        .collect();
    let casters: Vec<gpu_types::Caster> = cases
        .iter()
        .enumerate()
        .map(|(index, case)| gpu_types::Caster {
            light_local: case.light_local.to_array(),
            object: index as u32,
            extrusion: case.extrusion,
            corners_per_edge: 4,
            ..Default::default()
        })
        .collect();
    let inputs: Vec<[u32; 4]> = cases
        .iter()
        .enumerate()
        .map(|(index, case)| {
            let [x, y, z] = case.position_local.to_array().map(f32::to_bits);
            [x, y, z, index as u32]
        })
        .collect();
    let objects = storage(bytemuck::cast_slice(&objects));
    let casters = storage(bytemuck::cast_slice(&casters));
    let inputs = storage(bytemuck::cast_slice(&inputs));
    let results = storage(&vec![0; cases.len() * 16]);
    let layout = |bindings: &[(u32, bool)]| {
        let entries: Vec<_> = bindings
            .iter()
            .map(|&(binding, read_only)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("parity"),
            entries: &entries,
        })
    };
    let layouts = [
        layout(&[(1, true)]),
        layout(&[(0, true)]),
        layout(&[(0, true), (1, false)]),
    ];
    let group = |layout, buffers: &[(u32, &wgpu::Buffer)]| {
        let entries: Vec<_> = buffers
            .iter()
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("parity"),
            layout,
            entries: &entries,
        })
    };
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("parity"),
        layout: Some(&device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("parity"),
            bind_group_layouts: &[Some(&layouts[0]), Some(&layouts[2]), Some(&layouts[1])],
            immediate_size: 0,
        })),
        module: &module,
        entry_point: Some("parity"),
        compilation_options: Default::default(),
        cache: None,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group(&layouts[0], &[(1, &objects)]), &[]);
        pass.set_bind_group(2, &group(&layouts[1], &[(0, &casters)]), &[]);
        pass.set_bind_group(1, &group(&layouts[2], &[(0, &inputs), (1, &results)]), &[]);
        pass.dispatch_workgroups((cases.len() as u32).div_ceil(64), 1, 1);
    }
    context.queue.submit([encoder.finish()]);
    let bytes = read_buffer(context, &results, cases.len() as u64 * 16, "parity").expect("results are read");
    bytemuck::pod_collect_to_vec::<u8, [f32; 4]>(&bytes)
        .into_iter()
        .map(Vec4::from)
        .collect()
}

/// Indices of cases that differ by more than they may.
fn differing(cases: &[Case], got: &[Vec4]) -> Vec<usize> {
    assert_eq!(cases.len(), got.len());
    (0..cases.len())
        .filter(|&index| {
            let error = (got[index] - cases[index].expected()).abs();
            !error.cmple(cases[index].tolerance()).all()
        })
        .collect()
}

#[test]
fn extrude_equals_its_twin() {
    let context = strict_context();
    let cases = cases();
    let exact = cases.iter().filter(|case| case.tolerance() == Vec4::ZERO).count();
    assert!(exact > 5000, "too few cases are compared bit by bit");
    let got = on_gpu(&context, &cases, str::to_owned);
    let wrong = differing(&cases, &got);
    if let Some(&first) = wrong.first() {
        panic!(
            "{} of {} differ; first {:?}: {} on the GPU, {} on the CPU",
            wrong.len(),
            cases.len(),
            cases[first],
            got[first],
            cases[first].expected()
        );
    }
}

#[test]
fn parity_fails_when_one_vertex_moves() {
    let context = strict_context();
    let mut cases = cases();
    let got = on_gpu(&context, &cases, str::to_owned);
    for index in [0, 1, 2, 777] {
        let moved = cases[index].position_local.x * 1.001;
        let was = std::mem::replace(&mut cases[index].position_local.x, moved);
        // A directional light's corners are the same for every vertex.
        let seen = cases[index].light_local.w != 0.0;
        assert_eq!(differing(&cases, &got), if seen { vec![index] } else { vec![] });
        cases[index].position_local.x = was;
    }
}

#[test]
fn parity_fails_when_the_shader_changes() {
    let context = strict_context();
    let cases = cases();
    for (from, to) in [
        ("* caster.light_local.w", ""),
        ("from_light * caster.extrusion", "from_light"),
        ("vec4f(from_light, 0.0)", "vec4f(from_light, 1.0)"),
    ] {
        let got = on_gpu(&context, &cases, |source| {
            assert!(source.contains(from), "{from} is not in the shader");
            source.replace(from, to)
        });
        let wrong = differing(&cases, &got).len();
        assert!(wrong > 1000, "{from} → {to:?}: only {wrong} differ");
    }
}
