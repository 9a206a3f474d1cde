//! The functions of `shaders/techniques/maps/matrix.wgsl` compute what their twins in `matrix_faces` compute.

use antumbra::insides::gpu_types::{MapFace as GpuFace, MapLight};
use antumbra::insides::matrix_faces::{parallel_face, plane_depth, point_face, ray, showing, texel_at};
use antumbra::render::readback::read_buffer;
use antumbra::techniques::maps::{FaceProjection, MapFace};
use glam::{DMat3, DVec2, DVec3, Vec4};
use wgpu::util::DeviceExt;

use crate::harness::strict_context;

const WRAPPER: &str = "
struct ParityCase { place: vec4f, plane: vec4f, ndc: vec4f }
struct ParityResult { shown: vec4f, ray: vec4f, right: vec4f, up: vec4f }
@group(0) @binding(0) var<storage, read> parity_cases: array<ParityCase>;
@group(0) @binding(1) var<storage, read_write> parity_results: array<ParityResult>;
@compute @workgroup_size(64)
fn parity(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&parity_cases) {
        return;
    }
    let one = parity_cases[id.x];
    let face = showing(one.place.xyz);
    if face == NO_FACE {
        parity_results[id.x].shown.x = -1.0;
        return;
    }
    let plane = plane_in_face(face, one.plane.xyz, one.plane.w);
    let depth = -(plane.x * one.ndc.x + plane.y * one.ndc.y + plane.w) / plane.z;
    let clip = clip_in_face(face, one.place.xyz);
    let ray = ray_at(face, one.place.xyz);
    parity_results[id.x].shown = vec4f(f32(face), select(-1.0, depth, plane.z > 0.0), clip.z / clip.w, 0.0);
    parity_results[id.x].ray = vec4f(ray, 0.0);
    parity_results[id.x].right = vec4f(texel_side(face, 0u, one.place.xyz, clip.w, ray), 0.0);
    parity_results[id.x].up = vec4f(texel_side(face, 1u, one.place.xyz, clip.w, ray), 0.0);
}
";

/// Texels along a side.
const RESOLUTION: u32 = 256;

/// Position of the eye, the origin of the shader's space.
const EYE: DVec3 = DVec3::new(1.0, 2.0, -3.0);

/// A point, a plane, and a place of the picture.
struct Case {
    point: DVec3,
    normal: DVec3,
    offset: f64,
    ndc: DVec2,
}

/// A number between −1 and 1.
fn at(i: u32, k: u32) -> f64 {
    f64::from((i * k + 5) % 1009) / 504.5 - 1.0
}

fn cases() -> Vec<Case> {
    let case = |i| Case {
        point: DVec3::new(5.0 * at(i, 13), 1.5 * at(i, 29), 5.0 * at(i, 41)),
        normal: DVec3::new(
            0.5 * at(i, 7),
            if i % 8 == 0 { -1.0 } else { 1.0 },
            0.5 * at(i, 11),
        )
        .normalize(),
        offset: at(i, 17),
        ndc: DVec2::new(at(i, 19), at(i, 23)),
    };
    (0..3000).map(case).collect()
}

/// Faces of one light whose pictures overlap and are warped.
fn faces(is_parallel: bool) -> Vec<MapFace> {
    let face = |i: u32| {
        let z = DVec3::new(0.4 * at(i, 301), -1.0, 0.4 * at(i, 507)).normalize();
        let z = if is_parallel {
            DVec3::new(0.2, -1.0, 0.1).normalize()
        } else {
            z
        };
        let (x, y) = z.any_orthonormal_pair();
        let homography = DMat3::from_cols(
            DVec3::new(1.0, 0.2 * at(i, 605), 0.1 * at(i, 211)),
            DVec3::new(0.1, 1.2, 0.1 * at(i, 409)),
            DVec3::new(0.6 * at(i, 703), 0.1, 1.5),
        );
        let origin = DVec3::new(0.3, 4.0, -0.2);
        if is_parallel {
            let slope = DVec3::new(0.3, -0.2, 9.0);
            let smaller = DMat3::from_diagonal(DVec3::new(0.6, 0.6, 1.0));
            parallel_face(origin, [x, y, z], &(homography * smaller), slope, 12.0)
        } else {
            point_face(origin, [x, y, z], &homography, 0.01)
        }
    };
    (0..4).map(face).collect()
}

/// The constants of the shader.
fn constants(faces: &[MapFace]) -> MapLight {
    let mut constants = MapLight::default();
    for (out, face) in constants.faces.iter_mut().zip(faces) {
        let clip = face.clip_from_relative(EYE);
        let mut inverse = clip.inverse();
        if matches!(face.projection, FaceProjection::Matrix { parallel: true, .. }) {
            inverse.z_axis.w = 0.0; // up to rounding it is
        }
        *out = GpuFace {
            clip_from_relative: clip.as_mat4().to_cols_array_2d(),
            relative_from_clip: inverse.as_mat4().to_cols_array_2d(),
            ..GpuFace::default()
        };
    }
    let resolution = RESOLUTION as f32;
    constants.size = [resolution, resolution.recip(), 0.0, faces.len() as f32];
    constants
}

/// Runs the shader's functions on the GPU, their source changed by `spoil`.
fn on_gpu(faces: &[MapFace], cases: &[Case], spoil: impl Fn(String) -> String) -> Vec<[Vec4; 4]> {
    let context = strict_context();
    let shaders = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let read = |file: &str| std::fs::read_to_string(shaders.join(file)).expect("the shader is there");
    let constants_file = read("common/map.wgsl").replace("@group(2) @binding(0)", "@group(0) @binding(2)");
    let source = constants_file + &spoil(read("techniques/maps/matrix.wgsl")) + WRAPPER;
    let lines = source.lines().filter(|line| !line.starts_with('#'));
    let source = lines.collect::<Vec<_>>().join("\n");
    let device = &context.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("parity"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let buffer = |contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("parity"),
            contents,
            usage: usage | wgpu::BufferUsages::COPY_SRC,
        })
    };
    let inputs: Vec<[[f32; 4]; 3]> = cases
        .iter()
        .map(|case| {
            let offset = case.offset - case.normal.dot(EYE);
            let place = (case.point - EYE).extend(0.0).as_vec4();
            let plane = case.normal.extend(offset).as_vec4();
            let ndc = case.ndc.extend(0.0).extend(0.0).as_vec4();
            [place, plane, ndc].map(|part| part.to_array())
        })
        .collect();
    let size = cases.len() * 64;
    let buffers = [
        buffer(bytemuck::cast_slice(&inputs), wgpu::BufferUsages::STORAGE),
        buffer(&vec![0; size], wgpu::BufferUsages::STORAGE),
        buffer(bytemuck::bytes_of(&constants(faces)), wgpu::BufferUsages::UNIFORM),
    ];
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("parity"),
        layout: None,
        module: &module,
        entry_point: Some("parity"),
        compilation_options: Default::default(),
        cache: None,
    });
    let entries: Vec<_> = (0..)
        .zip(&buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("parity"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups((cases.len() as u32).div_ceil(64), 1, 1);
    }
    context.queue.submit([encoder.finish()]);
    let bytes = read_buffer(&context, &buffers[1], size as u64, "parity").expect("results are read");
    bytemuck::pod_collect_to_vec::<u8, [[f32; 4]; 4]>(&bytes)
        .into_iter()
        .map(|parts| parts.map(Vec4::from))
        .collect()
}

/// Whether a result of the GPU is that of the twin, up to rounding in `f32`.
fn equals(faces: &[MapFace], case: &Case, [shown, direction, right, up]: [Vec4; 4]) -> bool {
    let Some(expected) = showing(faces, case.point) else {
        return shown.x == -1.0;
    };
    if shown.x != expected.face as f32 {
        return false;
    }
    let face = &faces[expected.face];
    let is_near = |got: f32, expected: f64| (f64::from(got) - expected).abs() <= 2e-5 + 1e-3 * expected.abs();
    let depth = plane_depth(face, case.normal, case.offset, case.ndc).unwrap_or(-1.0);
    let (_, along) = ray(face, expected.ndc);
    let sides = texel_at(face, case.point, RESOLUTION);
    let is_same = |got: Vec4, expected: DVec3| {
        (got.truncate().as_dvec3() - expected).length() <= 1e-3 * expected.length()
    };
    is_near(shown.y, depth)
        && is_near(shown.z, expected.depth)
        && is_same(direction, along)
        && is_same(right, sides[0])
        && is_same(up, sides[1])
}

fn differing(faces: &[MapFace], cases: &[Case], got: &[[Vec4; 4]]) -> Vec<usize> {
    assert_eq!(cases.len(), got.len());
    (0..cases.len())
        .filter(|&index| !equals(faces, &cases[index], got[index]))
        .collect()
}

#[test]
fn faces_with_a_matrix_equal_their_twin() {
    let cases = cases();
    for is_parallel in [false, true] {
        let faces = faces(is_parallel);
        let got = on_gpu(&faces, &cases, |source| source);
        let wrong = differing(&faces, &cases, &got);
        if let Some(&first) = wrong.first() {
            let Case { point, normal, .. } = cases[first];
            panic!("{} differ; first {point} {normal}: {:?}", wrong.len(), got[first]);
        }
        for face in 0..faces.len() {
            let count = got.iter().filter(|parts| parts[0].x == face as f32).count();
            assert!(count > 50, "face {face} shows {count} points");
        }
        let hidden = got.iter().filter(|parts| parts[0].x == -1.0).count();
        let unlit = got
            .iter()
            .filter(|parts| parts[0].x >= 0.0 && parts[0].y == -1.0)
            .count();
        assert!(hidden > 50 && unlit > 50, "{hidden} points, {unlit} planes");
    }
}

#[test]
fn parity_of_faces_fails_when_the_shader_changes() {
    let cases = cases();
    for (is_parallel, from, to) in [
        (false, "border <= nearest", "border >= 0.5 * nearest"),
        (false, "position * light.w - light.xyz", "position - light.xyz"),
        (true, "column.xyz - position * column.w", "column.xyz"),
        (true, "vec4f(normal, -offset)", "vec4f(normal, offset)"),
    ] {
        let faces = faces(is_parallel);
        let got = on_gpu(&faces, &cases, |source| {
            assert!(source.contains(from), "{from} is not in the shader");
            source.replace(from, to)
        });
        let wrong = differing(&faces, &cases, &got).len();
        assert!(wrong > 200, "{from} → {to}: only {wrong} differ");
    }
}
