//! The tables of angles agree with what the shader computes without them.

use antumbra::insides::constants::{ANGLE_STEPS, lookup_entries};
use antumbra::render::readback::read_buffer;
use wgpu::util::DeviceExt;

use crate::harness::{shaders, strict_context};

/// The share of the disc beyond a chord: by tables, and computed.
const SHADER: &str = "
#import antumbra::wedge_light::{behind, Maths}
#import antumbra::coverage::Projected
@group(0) @binding(0) var<storage, read> chords: array<vec4f>;
@group(1) @binding(0) var<storage, read_write> results: array<vec2f>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&chords) {
        let edge = Projected(chords[id.x].xy, chords[id.x].zw, true);
        let by_table = behind(edge, Maths(true, true, false)).a;
        results[id.x] = vec2f(by_table, behind(edge, Maths(true, false, false)).a);
    }
}";

/// Pairs of points of the unit disc.
fn chords() -> Vec<[f32; 4]> {
    let mut state = 7u32;
    let mut unit = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1u32 << 24) as f32
    };
    let mut point = || {
        let (sin, cos) = (unit() * std::f32::consts::TAU).sin_cos();
        let radius = unit().sqrt();
        [radius * cos, radius * sin]
    };
    (0..10_000)
        .map(|_| {
            let ([a, b], [c, d]) = (point(), point());
            [a, b, c, d]
        })
        .collect()
}

fn shares(chords: &[[f32; 4]], entries: &[[f32; 4]]) -> Vec<[f32; 2]> {
    let context = strict_context();
    let device = &context.device;
    let module = shaders().compose("disc tables", SHADER).expect("it composes");
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
    let buffer = |contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents,
            usage,
        })
    };
    let storage = wgpu::BufferUsages::STORAGE;
    let size = chords.len() * 8;
    let input = buffer(bytemuck::cast_slice(chords), storage);
    let output = buffer(&vec![0; size], storage | wgpu::BufferUsages::COPY_SRC);
    let light = buffer(&[0; 1024], wgpu::BufferUsages::UNIFORM);
    let tables = buffer(bytemuck::cast_slice(entries), storage);
    let groups: [&[(u32, &wgpu::Buffer)]; 3] =
        [&[(0, &input)], &[(0, &output)], &[(2, &light), (3, &tables)]];
    let groups = [0, 1, 2].map(|group: u32| {
        let entries: Vec<_> = groups[group as usize]
            .iter()
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(group),
            entries: &entries,
        })
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        for (index, group) in groups.iter().enumerate() {
            pass.set_bind_group(index as u32, group, &[]);
        }
        pass.dispatch_workgroups((chords.len() as u32).div_ceil(64), 1, 1);
    }
    context.queue.submit([encoder.finish()]);
    let bytes = read_buffer(&context, &output, size as u64, "shares").expect("they are read");
    bytemuck::pod_collect_to_vec(&bytes)
}

#[test]
fn tables_of_discs_give_what_is_computed() {
    let chords = chords();
    let entries = lookup_entries();
    let shares_of = |entries: &[[f32; 4]]| shares(&chords, entries);
    let right = shares_of(&entries);
    let computed = right.iter().filter(|[_, computed]| *computed > 0.01).count();
    assert!(computed > 5000, "{computed} chords cut something off");
    let most = right
        .iter()
        .map(|[by_table, computed]| (by_table - computed).abs());
    let most = most.fold(0.0, f32::max);
    assert!(most <= 1e-3, "{most}");
    // Angles that are 2 % too large show in what is looked up, and in nothing else.
    let mut wrong = entries.clone();
    wrong[..=ANGLE_STEPS]
        .iter_mut()
        .for_each(|entry| entry[0] *= 1.02);
    let spoilt = shares_of(&wrong);
    let moved = |by: usize| {
        let pairs = right.iter().zip(&spoilt);
        pairs.filter(|(a, b)| (a[by] - b[by]).abs() > 1e-3).count()
    };
    assert!(moved(0) > 1000 && moved(1) == 0, "{} {}", moved(0), moved(1));
}
