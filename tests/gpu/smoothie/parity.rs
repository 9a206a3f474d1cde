//! The shader expands edges and reads texels as its CPU twin does.

use antumbra::insides::smoothies::{
    Beside, DISC, DISC_ALONE, SECTOR, SmoothieEdge, SmoothieFace, VERTICES, resolve_from_point,
    resolve_parallel, smoothie_vertex, visibility_from_point, visibility_parallel,
};
use antumbra::prelude::*;
use antumbra::render::readback::read_buffer;
use antumbra::techniques::maps::{FaceProjection, MapFace};
use glam::{DVec3, Vec2, Vec3};
use wgpu::util::DeviceExt;

use crate::harness::{shaders, strict_context};

const FILE: &str = "shaders/techniques/smoothie/edge.wgsl";

/// Calls the shader's own functions. Four numbers of a case are alpha, own distance, and distances of a caster and a
/// receiver beyond it.
const WRAPPER: &str = "
struct ParityResult { position: vec4f, rest: vec4f, stored: vec4f, seen: vec4f }
@group(3) @binding(0) var<storage, read> parity_cases: array<vec4f>;
@group(3) @binding(1) var<storage, read_write> parity_results: array<ParityResult>;
@compute @workgroup_size(64)
fn parity(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&parity_cases) {
        let corner = smoothie_vertex(edges[id.x / 24u], id.x % 24u);
        let one = parity_cases[id.x];
        let point = resolve_from_point(one.x, one.y, one.z, 16.0);
        let sun = resolve_parallel(one.x, one.y, 1.0 / one.z, 3.0);
        parity_results[id.x] = ParityResult(
            corner.position_clip,
            vec4f(corner.offset, corner.width, corner.along),
            vec4f(point, sun),
            vec4f(
                visibility_from_point(point, one.w, one.z, 16.0),
                visibility_parallel(sun, 1.0 / one.w, 1.0 / one.z, 3.0),
                0.0,
                0.0,
            ),
        );
    }
}
";

struct Random(fastrand::Rng);

impl Random {
    fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    fn unit(&mut self) -> f32 {
        self.0.f32()
    }

    fn place(&mut self) -> Vec3 {
        Vec3::new(
            self.unit() * 4.0 - 2.0,
            self.unit() * 4.0 - 2.0,
            self.unit() * 6.0 - 1.0,
        )
    }
}

fn faces() -> [SmoothieFace; 2] {
    let projections = [
        FaceProjection::Perspective {
            tangent: 0.9,
            near: 0.01,
        },
        FaceProjection::Parallel {
            half: 3.0,
            length: 20.0,
        },
    ];
    projections.map(|projection| {
        let face = MapFace {
            origin: DVec3::new(0.1, 0.2, -0.3),
            axes: [DVec3::NEG_X, DVec3::Y, DVec3::Z],
            projection,
        };
        let beside = Beside {
            metres: 0.1,
            share: 0.0,
            drop: 3.0,
        };
        SmoothieFace::new(&face, DVec3::ZERO, 512, &beside)
    })
}

fn edges() -> Vec<SmoothieEdge> {
    let mut random = Random::new(17);
    let kinds = [SECTOR, SECTOR, DISC, DISC_ALONE];
    (0..400)
        .map(|index| SmoothieEdge {
            start: random.place().to_array(),
            width_start: random.unit() * 0.3,
            end: random.place().to_array(),
            width_end: random.unit() * 0.3,
            next: random.place().to_array(),
            kind: kinds[index % kinds.len()],
        })
        .collect()
}

fn cases(count: usize) -> Vec<[f32; 4]> {
    let mut random = Random::new(23);
    (0..count)
        .map(|_| {
            let along = 0.2 + 4.0 * random.unit();
            let caster = along + 6.0 * random.unit() - 0.5;
            let receiver = along + (caster - along) * random.unit();
            [random.unit(), along, caster.recip(), receiver.recip()]
        })
        .collect()
}

/// Sixteen numbers for each vertex of each edge.
fn on_gpu(context: &RenderContext, face: &SmoothieFace, spoil: impl Fn(String) -> String) -> Vec<[f32; 16]> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(FILE);
    let source = std::fs::read_to_string(path).expect("the shader is there");
    let source = source.replace(
        "::{CLEAR,",
        "::{visibility_from_point, visibility_parallel, CLEAR,",
    );
    let source = spoil(source) + WRAPPER;
    let module = shaders()
        .compose(FILE, &source)
        .expect("the wrapped file composes");
    let device = &context.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("parity"),
        source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("parity"),
        layout: None,
        module: &module,
        entry_point: Some("parity"),
        compilation_options: Default::default(),
        cache: None,
    });
    let edges = edges();
    let count = edges.len() * VERTICES as usize;
    let buffer = |contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("parity"),
            contents,
            usage: usage | wgpu::BufferUsages::COPY_SRC,
        })
    };
    let storage = wgpu::BufferUsages::STORAGE;
    let edges = buffer(bytemuck::cast_slice(&edges), storage);
    let face = buffer(bytemuck::bytes_of(face), wgpu::BufferUsages::UNIFORM);
    let cases = buffer(bytemuck::cast_slice(&cases(count)), storage);
    let results = buffer(&vec![0; count * 64], storage);
    let group = |index, buffers: &[&wgpu::Buffer]| {
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("parity"),
            layout: &pipeline.get_bind_group_layout(index),
            entries: &entries,
        })
    };
    let groups = [
        (0, group(0, &[&edges])),
        (1, group(1, &[&face])),
        (3, group(3, &[&cases, &results])),
    ];
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        for (index, group) in &groups {
            pass.set_bind_group(*index, group, &[]);
        }
        pass.dispatch_workgroups((count as u32).div_ceil(64), 1, 1);
    }
    context.queue.submit([encoder.finish()]);
    let bytes = read_buffer(context, &results, count as u64 * 64, "parity").expect("the results can be read");
    bytemuck::pod_collect_to_vec(&bytes)
}

/// Cases where the shader and the twin differ.
fn differing(face: &SmoothieFace, got: &[[f32; 16]]) -> usize {
    let edges = edges();
    let cases = cases(got.len());
    let near = |a: f32, b: f32| (a - b).abs() <= 2e-4 * (1.0 + a.abs().max(b.abs()));
    let is_wrong = |(index, got): (usize, &[f32; 16])| {
        let vertex = smoothie_vertex(&edges[index / VERTICES as usize], face, index as u32 % VERTICES);
        let [alpha, along, behind, receiver] = cases[index];
        let point = resolve_from_point(alpha, along, behind, 16.0);
        let sun = resolve_parallel(alpha, along, behind.recip(), 3.0);
        // Just at the caster, rounding decides whether a smoothie darkens it.
        let decided = |stored: Vec2| stored.y < -1e-3 || stored.y == 0.0;
        let seen = [
            visibility_from_point(point, receiver, behind, 16.0),
            visibility_parallel(sun, receiver.recip(), behind.recip(), 3.0),
        ];
        let position = vertex.position_clip.to_array();
        let rest = [vertex.offset.x, vertex.offset.y, vertex.width, vertex.along];
        let expanded = position
            .into_iter()
            .chain(rest)
            .zip(got)
            .any(|(a, b)| !near(a, *b));
        let values = [point.x, point.y, sun.x, sun.y, seen[0], seen[1]];
        let shaded = values.into_iter().zip(&got[8..]).any(|(a, b)| !near(a, *b));
        expanded || (shaded && decided(point) && decided(sun))
    };
    got.iter().enumerate().filter(|case| is_wrong(*case)).count()
}

#[test]
fn smoothies_equal_their_twin() {
    let context = strict_context();
    for face in faces() {
        let got = on_gpu(&context, &face, |source| source);
        let wrong = differing(&face, &got);
        println!("{wrong} of {} vertices differ", got.len());
        // A turn of almost half a circle may go either way.
        assert!(wrong <= got.len() / 1000, "{wrong} of {}", got.len());
    }
}

#[test]
fn parity_fails_when_corners_or_widths_change() {
    let context = strict_context();
    let [face, _] = faces();
    for (from, to) in [
        ("last = turn + OVERLAP;", "last = turn;"),
        (
            "let offset = select(inside, width, outside);",
            "let offset = select(inside, width * 1.01, outside);",
        ),
    ] {
        let got = on_gpu(&context, &face, |source| {
            assert!(source.contains(from));
            source.replace(from, to)
        });
        assert!(differing(&face, &got) > got.len() / 50, "{from}");
    }
}
